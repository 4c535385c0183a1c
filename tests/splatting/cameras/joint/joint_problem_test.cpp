// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/joint/joint_problem.h"

#include <gtest/gtest.h>

#include "kernels/core/error.h"
#include "solver/check_problem.h"
#include "solver/internal/derivative_check.inl"
#include "solver/reduced_system.h"
#include "tests/problems/gaussian_splatting/host_vectors.h"
#include "tests/splatting/cameras/joint_setup.h"
#include "tests/support/adjoint.h"
#include "tests/support/linearize_at.h"

namespace vesta::gs {
namespace {

using test::JointSetup;
using test::RandomVector;

constexpr FreeUnknowns kKinds[] = {{.pose = true, .color = false}, {.pose = false, .color = true}, {true, true}};

void ExpectNoFault(const JointSetup<double>& setup, bool exact_blocks) {
  JointProblem<CpuBackend<double>> problem = setup.Make();
  CpuBackend<double> backend;
  const ProblemCheck check =
      CheckProblem<CpuBackend<double>>(backend, problem, setup.x, {.exact_blocks = exact_blocks});
  EXPECT_TRUE(check.ok()) << check.Report();
}

// Products, W, the gradient along Plus, and blocks. W of this loss is pointwise, so all blocks are exact.
TEST(JointProblem, HasNoFault) {
  for (const FreeUnknowns& free : kKinds) {
    JointSetup<double> setup(free, 4, 8, 1, 5);
    setup.options.splats.weights.ssim = 0;
    // Derivatives cannot be checked at the kinks of |e|.
    setup.options.splats.weights.pixel = PixelLinearization::kL2;
    ExpectNoFault(setup, true);
  }
}

// The complete loss: blocks of splats then only approximate the blocks of H.
TEST(JointProblem, HasNoFaultWithSsim) {
  for (const FreeUnknowns& free : kKinds) ExpectNoFault({free, 3, 8, 1, 6}, false);
}

// CheckProblem skips J for weighted problems.
TEST(JointProblem, JIsTheDerivativeOfTheResiduals) {
  const JointSetup<double> setup({true, true}, 2, 10, 2, 7);
  JointProblem<CpuBackend<double>> problem = setup.Make();
  CpuBackend<double> backend;
  const auto linearization = LinearizeAt(problem, setup.x);
  const Index n = linearization->num_residuals();
  HostBuffer<double> Jv(n), moved(problem.num_parameters());
  const auto residuals = [&](const HostBuffer<double>& v, double step) {
    HostBuffer<double> delta(v.size());
    backend.Axpby(step, v, 0.0, delta);
    problem.Plus(backend, setup.x, delta, moved);
    const auto there = LinearizeAt(problem, moved);
    return std::vector<double>(there->residuals().begin(), there->residuals().end());
  };
  const auto check = [&](const HostBuffer<double>& v, const std::string& what) {
    constexpr double kStep = 1e-6;
    const std::vector<double> above = residuals(v, kStep), below = residuals(v, -kStep);
    linearization->ApplyJ(v, Jv);
    const double scale = backend.MaxAbs(Jv);
    ASSERT_GT(scale, 1e-6) << what;
    int beyond = 0;
    for (Index i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      beyond += std::abs((above[at] - below[at]) / (2 * kStep) - Jv[i]) > 1e-4 * scale ? 1 : 0;
    }
    EXPECT_LE(beyond, 8) << what;  // an alpha crosses 1/255 between the two points
  };
  for (std::uint64_t seed = 1; seed < 4; ++seed) check(RandomVector<double>(problem.num_tangent(), seed), "random");
  for (Index k = problem.layout().splats; k < problem.num_tangent(); ++k) {
    HostBuffer<double> v(problem.num_tangent());
    v[k] = 1;
    check(v, "entry " + std::to_string(k - problem.layout().splats) + " of views");
  }
}

template <class S>
void ExpectAdjoint(double tolerance) {
  for (const FreeUnknowns& free : kKinds) {
    const JointSetup<S> setup(free, 3, 40, 2, 8);
    JointProblem<CpuBackend<S>> problem = setup.Make();
    const auto linearization = LinearizeAt(problem, setup.x);
    const HostBuffer<S> v = RandomVector<S>(problem.num_tangent(), 1),
                        u = RandomVector<S>(linearization->num_residuals(), 2);
    HostBuffer<S> Jv(u.size()), JTu(v.size());
    linearization->ApplyJ(v, Jv);
    linearization->ApplyJT(u, JTu);
    const auto vector = [](const HostBuffer<S>& b) { return std::vector<S>(b.begin(), b.end()); };
    EXPECT_LT(vesta::test::AdjointGap(vector(u), vector(Jv), vector(JTu), vector(v)), tolerance);
  }
}
TEST(JointProblem, ProductsAreAdjointInDouble) { ExpectAdjoint<double>(1e-12); }
TEST(JointProblem, ProductsAreAdjointInFloat) { ExpectAdjoint<float>(1e-5); }

// Products, the gradient along Plus, and blocks.
TEST(JointProblem, OfMaskedViewsHasNoFault) {
  JointSetup<double> setup({true, true}, 3, 8, 1, 5);
  setup.options.splats.weights.ssim = 0;
  setup.options.splats.weights.pixel = PixelLinearization::kL2;
  const Index pixels = setup.ring.views[0].shape().PlaneSize();
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(pixels), 1);
  std::fill_n(mask.begin(), pixels / 2, std::uint8_t{0});
  JointProblem<CpuBackend<double>> whole = setup.Make();
  const double cost = whole.Cost(setup.x, std::vector<Index>{0, 1, 2});
  for (auto& view : setup.ring.views) view.mask = {mask.data(), pixels};
  JointProblem<CpuBackend<double>> problem = setup.Make();
  EXPECT_LT(problem.Cost(setup.x, std::vector<Index>{0, 1, 2}), 0.95 * cost);
  ExpectNoFault(setup, true);
}

// The SSIM part of W is not pointwise, but blocks of views are exact.
TEST(JointProblem, BlocksOfViewsAreExact) {
  const JointSetup<double> setup({true, true}, 3, 20, 1, 9);
  JointProblem<CpuBackend<double>> problem = setup.Make();
  const JointLayout& layout = problem.layout();
  const auto linearization = LinearizeAt(problem, setup.x);
  const std::vector<BlockGroup> groups = linearization->block_groups();
  BlockDiagonal<CpuBackend<double>> blocks(layout.num_tangent(), groups);
  linearization->BlockGram(blocks);
  const BlockGroup& views = groups.back();
  ASSERT_EQ(views.size, 12);
  ASSERT_EQ(views.count, 3);
  HostBuffer<double> v(layout.num_tangent()), Hv(layout.num_tangent());
  for (Index block = 0; block < views.count; ++block) {
    for (int col = 0; col < views.size; ++col) {
      v.Resize(v.size());
      v[views.Parameter(block, col)] = 1;
      linearization->ApplyH(v, Hv);
      const double own = Hv[views.Parameter(block, col)];
      ASSERT_GT(own, 0);
      for (int row = col; row < views.size; ++row) {
        const double expected = Hv[views.Parameter(block, row)];
        const double value = blocks.values(2)[PackedLower(row, col) * views.count + block];
        EXPECT_NEAR(value, expected, 1e-9 * std::max(own, std::abs(expected))) << row << ' ' << col;
      }
      // Different views are not coupled.
      for (Index other = 0; other < views.count; ++other) {
        if (other == block) continue;
        for (int row = 0; row < views.size; ++row) EXPECT_EQ(Hv[views.Parameter(other, row)], 0);
      }
    }
  }
}

// S x = B x - E C^-1 E^T x, from products with H. The reduced solution also solves the full system.
TEST(JointProblem, EliminatesViewsExactly) {
  for (const FreeUnknowns& free : kKinds) {
    JointSetup<double> setup(free, 3, 12, 1, 10);
    setup.options.eliminate_views = true;
    JointProblem<CpuBackend<double>> problem = setup.Make();
    const JointLayout& layout = problem.layout();
    const auto linearization = LinearizeAt(problem, setup.x);
    const auto reduced = linearization->MakeReducedSystem();
    ASSERT_TRUE(reduced);
    ASSERT_EQ(reduced->size(), layout.splats);
    HostBuffer<double> metric(layout.num_tangent());
    linearization->DiagJTJ(metric);
    for (double& d : metric) d += 1;
    constexpr double kLambda = 0.3;
    reduced->SetDamping(kLambda, metric);
    // A right-hand side with a known solution.
    CpuBackend<double> backend;
    const HostBuffer<double> step = RandomVector<double>(layout.num_tangent(), 3);
    HostBuffer<double> rhs(layout.num_tangent());
    linearization->ApplyH(step, rhs);
    backend.AddScaled(kLambda, metric, step, rhs);
    const HostSpan<const double> kept = step.view().subspan(0, layout.splats);
    HostBuffer<double> reduced_rhs(layout.splats), product(layout.splats), found(layout.num_tangent());
    reduced->ReduceRhs(rhs, reduced_rhs);
    reduced->Apply(kept, product);
    const double scale = backend.MaxAbs(product);
    for (Index k = 0; k < layout.splats; ++k) EXPECT_NEAR(product[k], reduced_rhs[k], 1e-9 * scale) << k;
    std::copy(kept.begin(), kept.end(), found.begin());
    reduced->BackSubstitute(rhs, found);
    for (Index k = layout.splats; k < layout.num_tangent(); ++k) EXPECT_NEAR(found[k], step[k], 1e-7) << k;
  }
  const JointSetup<double> plain({}, 3, 12, 1, 10);
  JointProblem<CpuBackend<double>> problem = plain.Make();
  EXPECT_FALSE(LinearizeAt(problem, plain.x)->MakeReducedSystem());
}

TEST(JointProblem, CostIsTheSumOverViews) {
  const JointSetup<float> setup({true, true}, 4, 30, 1, 11);
  JointProblem<CpuBackend<float>> problem = setup.Make();
  double sum = 0;
  for (Index v = 0; v < 4; ++v) sum += problem.Cost(setup.x, std::span(&v, 1));
  EXPECT_NEAR(problem.Cost(setup.x), sum, 1e-9 * sum);
}

TEST(JointProblem, InFloatIsThatInDouble) {
  const JointSetup<double> exact({true, true}, 3, 30, 1, 12);
  const JointSetup<float> rounded({true, true}, 3, 30, 1, 12);
  JointProblem<CpuBackend<double>> a = exact.Make();
  JointProblem<CpuBackend<float>> b = rounded.Make();
  EXPECT_NEAR(b.Cost(rounded.x), a.Cost(exact.x), 1e-5 * a.Cost(exact.x));
  HostBuffer<double> expected(a.num_tangent()), diagonal(a.num_tangent());
  HostBuffer<float> g(b.num_tangent());
  const auto linearization = LinearizeAt(a, exact.x);
  linearization->Gradient(expected);
  linearization->DiagJTJ(diagonal);
  LinearizeAt(b, rounded.x)->Gradient(g);
  const Index first = a.layout().splats;
  double largest = 0;
  for (Index k = first; k < g.size(); ++k) largest = std::max(largest, std::abs(expected[k]) / std::sqrt(diagonal[k]));
  for (Index k = first; k < g.size(); ++k) {
    EXPECT_NEAR(static_cast<double>(g[k]), expected[k], 2e-3 * largest * std::sqrt(diagonal[k])) << k - first;
  }
}

TEST(JointProblem, AViewThatSeesNothingAndNoGain) {
  JointSetup<double> setup({true, true}, 2, 20, 1, 13);
  JointProblem<CpuBackend<double>> problem = setup.Make();
  const JointLayout& layout = problem.layout();
  // The first camera turned by 180 degrees.
  layout.SetUnknowns({{{0, 0, 1, 0}, {}}, {}}, 1, layout.RestOf(setup.x.view()));
  const auto linearization = LinearizeAt(problem, setup.x);
  HostBuffer<double> g(problem.num_tangent()), d(problem.num_tangent());
  linearization->Gradient(g);
  linearization->DiagJTJ(d);
  CpuBackend<double> backend;
  EXPECT_TRUE(backend.AllFinite(g) && backend.AllFinite(d));
  EXPECT_TRUE(std::isfinite(problem.Cost(setup.x)));
  layout.SetUnknowns({{}, {{1, 0, 1}, {}}}, 1, layout.RestOf(setup.x.view()));
  EXPECT_EQ(problem.Cost(setup.x), HUGE_VAL);
}

TEST(JointProblem, RefusesWhatIsNoProblem) {
  const JointSetup<float> setup({}, 2, 10, 1, 14);
  const auto make = [&](const auto& change) {
    JointProblemOptions options = setup.options;
    change(options);
    return JointProblem<CpuBackend<float>>(options, setup.ring.views);
  };
  EXPECT_NO_THROW(make([](JointProblemOptions&) {}));
  EXPECT_THROW(make([](JointProblemOptions& o) { o.free.pose = false; }), Error);
  EXPECT_THROW(make([](JointProblemOptions& o) { o.prior.weight = -1; }), Error);
  EXPECT_THROW(make([](JointProblemOptions& o) { o.prior.depth = 0; }), Error);
  EXPECT_THROW(make([](JointProblemOptions& o) { o.free.lens = true; }), Error);
  EXPECT_THROW(JointProblem<CpuBackend<float>>(setup.options, {}), Error);
}

}  // namespace
}  // namespace vesta::gs
