// SPDX-License-Identifier: Apache-2.0
// The operators keep their properties with every option.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "solver/compose.h"
#include "solver/internal/derivative_check.inl"
#include "solver/levenberg_marquardt.h"
#include "tests/problems/gaussian_splatting/host_vectors.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/any_threads.h"
#include "tests/support/linearize_at.h"

namespace vesta::gs {
namespace {

using test::ApplyH;
using test::Distance;
using test::Norm;
using test::RandomVector;
using test::RingProblem;

constexpr Index kCount = 30;
constexpr Index kFew = 4;  // for tests with a product per parameter

struct Variant {
  const char* name;
  void (*apply)(SplatProblemOptions&);
};
const Variant kVariants[] = {
    {"cached_views", [](SplatProblemOptions& o) { o.jacobian = JacobianKind::kCachedViews; }},
    {"cache32", [](SplatProblemOptions& o) { o.jacobian = JacobianKind::kCache32; }},
    {"cache16", [](SplatProblemOptions& o) { o.jacobian = JacobianKind::kCache16; }},
    {"on_the_fly", [](SplatProblemOptions& o) { o.jacobian = JacobianKind::kOnTheFly; }},
    {"random_batches",
     [](SplatProblemOptions& o) {
       o.batches = {2, 1, BatchChoice::kRandom, 3};
     }},
    {"paper_code",
     [](SplatProblemOptions& o) {
       o.weights = {
           .l1 = 1, .ssim = 0.25, .pixel = PixelLinearization::kHuber, .structure = SsimLinearization::kRootCenter};
     }},
};

class SplatVariants : public testing::TestWithParam<Variant> {};
INSTANTIATE_TEST_SUITE_P(Options, SplatVariants, testing::ValuesIn(kVariants),
                         [](const auto& param) { return param.param.name; });

template <class S>
void CheckOperators(const Variant& variant, double tolerance) {
  CpuBackend<S> backend;
  RingProblem<S> ring(3, kCount, 1, 10);
  variant.apply(ring.options);
  SplatProblem<CpuBackend<S>> problem = ring.Make();
  for (int batch = 0; batch < problem.num_batches(); ++batch) {
    const auto linearization = LinearizeAt(problem, ring.x, batch);
    JacobianMap<CpuBackend<S>> J(linearization->get());
    EXPECT_LE(WorstAdjointError(backend, J, 11), tolerance);
    const HostBuffer<S> v = RandomVector<S>(problem.num_parameters(), 12);
    const HostBuffer<S> w = RandomVector<S>(problem.num_parameters(), 13);
    const HostBuffer<S> Hv = ApplyH(*linearization, v), Hw = ApplyH(*linearization, w);
    EXPECT_NEAR(backend.Dot(w, Hv), backend.Dot(v, Hw), tolerance * std::sqrt(backend.Dot(Hv, Hv) * backend.Dot(w, w)));
    EXPECT_GT(backend.Dot(v, Hv), 0);
    // ApplyH equals ApplyJ, ApplyW and ApplyJT.
    EXPECT_LE(Distance(Hv, test::ApplyParts(*linearization, v)), tolerance * Norm(Hv));
    EXPECT_NEAR(linearization->Curvature(v), backend.Dot(v, Hv), tolerance * Norm(v) * Norm(Hv));
  }
}

TEST_P(SplatVariants, OperatorsAreAdjointAndSymmetric) {
  CheckOperators<double>(GetParam(), 1e-12);
  CheckOperators<float>(GetParam(), 1e-5);
}

// Without SSIM. Gram matrices are recomputed from the splats, so 16-bit entries in the products make a difference.
TEST_P(SplatVariants, DiagonalAndBlocksAreThoseOfH) {
  using B = CpuBackend<double>;
  B backend;
  RingProblem<double> ring(3, kFew, 1, 40);
  ring.options.weights.ssim = 0;
  GetParam().apply(ring.options);
  SplatProblem<CpuBackend<double>> problem = ring.Make();
  const double tolerance = ring.options.jacobian == JacobianKind::kCache16 ? 2e-3 : 1e-10;
  for (int batch = 0; batch < problem.num_batches(); ++batch) {
    const auto linearization = LinearizeAt(problem, ring.x, batch);
    EXPECT_LE(DiagonalError<B>(backend, linearization->get()), tolerance);
    EXPECT_LE(BlockError<B>(backend, linearization->get()), tolerance);
  }
}

TEST_P(SplatVariants, SameBitsForAnyNumberOfThreadsAndEveryTurnAlike) {
  RingProblem<float> ring(3, 200, 1, 80);
  GetParam().apply(ring.options);
  const HostBuffer<float> v = RandomVector<float>(ring.x.size(), 81);
  int turns_before = 0;
  vesta::test::ExpectSameForAnyThreads([&] {
    SplatProblem<CpuBackend<float>> problem = ring.Make();
    for (int turn = 0; turn < turns_before; ++turn) problem.OnNewPoint(turn);
    ++turns_before;
    problem.OnNewPoint(5);
    std::vector<float> all;
    for (int batch = 0; batch < problem.num_batches(); ++batch) {
      const auto linearization = LinearizeAt(problem, ring.x, batch);
      HostBuffer<float> out(v.size());
      linearization->Gradient(out);
      all.insert(all.end(), out.begin(), out.end());
      linearization->ApplyH(v, out);
      all.insert(all.end(), out.begin(), out.end());
      BlockDiagonal<CpuBackend<float>> blocks(v.size(), linearization->block_groups());
      linearization->BlockGram(blocks);
      all.insert(all.end(), blocks.all_values().begin(), blocks.all_values().end());
    }
    return all;
  });
}

// Released results are computed again on request.
TEST_P(SplatVariants, GradientAndBlocksAskedForAgainAreTheSame) {
  RingProblem<float> ring(3, kCount, 2, 20);
  GetParam().apply(ring.options);
  SplatProblem<CpuBackend<float>> problem = ring.Make();
  const auto linearization = LinearizeAt(problem, ring.x);
  std::vector<std::vector<float>> results;
  for (int again = 0; again < 2; ++again) {
    HostBuffer<float> gradient(ring.x.size()), diagonal(ring.x.size());
    BlockDiagonal<CpuBackend<float>> blocks(ring.x.size(), linearization->block_groups());
    linearization->Gradient(gradient);
    if (again == 0) linearization->DiagJTJ(diagonal);  // the first BlockGram reuses the result
    linearization->BlockGram(blocks);
    std::vector<float>& all = results.emplace_back(gradient.begin(), gradient.end());
    all.insert(all.end(), blocks.all_values().begin(), blocks.all_values().end());
  }
  EXPECT_TRUE(results[0] == results[1]);
}

TEST(SplatCache, GivesTheProductsOfRecomputation) {
  RingProblem<double> ring(3, kCount, 2, 20);
  const HostBuffer<double> v = RandomVector<double>(ring.x.size(), 21);
  SplatProblem<CpuBackend<double>> recompute = ring.Make();
  const auto reference = LinearizeAt(recompute, ring.x);
  const HostBuffer<double> expected = ApplyH(*reference, v);
  HostBuffer<double> gradient(v.size()), cached_gradient(v.size());
  reference->Gradient(gradient);
  for (const auto& [kind, tolerance] : {std::pair(JacobianKind::kCache32, 1e-12), {JacobianKind::kCache16, 1e-3}}) {
    ring.options.jacobian = kind;
    SplatProblem<CpuBackend<double>> problem = ring.Make();
    const auto linearization = LinearizeAt(problem, ring.x);
    const double distance = Distance(ApplyH(*linearization, v), expected) / Norm(expected);
    EXPECT_LE(distance, tolerance);
    EXPECT_EQ(distance > 1e-7, kind == JacobianKind::kCache16) << "only 16-bit entries are rounded";
    linearization->Gradient(cached_gradient);
    EXPECT_EQ(Distance(cached_gradient, gradient), 0) << "the gradient never uses the cache";
  }
}

// Views built again for each product equal cached ones.
TEST(SplatRebuild, GivesTheBitsOfViewsThatAreHeld) {
  RingProblem<float> ring(3, kCount, 2, 20);
  const HostBuffer<float> v = RandomVector<float>(ring.x.size(), 21);
  std::vector<std::vector<float>> results;
  for (const JacobianKind kind : {JacobianKind::kCachedViews, JacobianKind::kOnTheFly}) {
    ring.options.jacobian = kind;
    SplatProblem<CpuBackend<float>> problem = ring.Make();
    const auto linearization = LinearizeAt(problem, ring.x);
    std::vector<float>& all = results.emplace_back();
    const auto keep = [&](const HostBuffer<float>& values) { all.insert(all.end(), values.begin(), values.end()); };
    HostBuffer<float> of_x(v.size()), of_residuals(linearization->num_residuals());
    for (int again = 0; again < 2; ++again) keep(ApplyH(*linearization, v));
    linearization->Gradient(of_x);
    keep(of_x);
    linearization->DiagJTJ(of_x);
    keep(of_x);
    linearization->ApplyJ(v, of_residuals);
    keep(of_residuals);
    HostBuffer<float> weighted(of_residuals.size());
    linearization->ApplyW(of_residuals, weighted);
    keep(weighted);
    linearization->ApplyJT(weighted, of_x);
    keep(of_x);
    const auto residuals = linearization->residuals();
    all.insert(all.end(), residuals.begin(), residuals.end());
  }
  EXPECT_TRUE(results[0] == results[1]);
}

// The mean over many draws of views is the full problem.
TEST(SplatBatches, OfSomeViewsAreRightInTheMean) {
  RingProblem<double> ring(3, kCount, 0, 60);
  ring.options.weights.ssim = 0;
  const Index n = ring.x.size();
  SplatProblem<CpuBackend<double>> whole = ring.Make();
  HostBuffer<double> expected(n), gradient(n), mean(n), mean_gradient(n), part(n);
  const auto all = LinearizeAt(whole, ring.x);
  all->DiagJTJ(expected);
  all->Gradient(gradient);
  ring.options.batches = {2, 1, BatchChoice::kRandom, 1};
  SplatProblem<CpuBackend<double>> some = ring.Make();
  CpuBackend<double> backend;
  constexpr int kTurns = 300;
  for (int turn = 0; turn < kTurns; ++turn) {
    some.OnNewPoint(turn);
    for (int batch = 0; batch < 2; ++batch) {
      const auto linearization = LinearizeAt(some, ring.x, batch);
      linearization->DiagJTJ(part);
      backend.Axpby(1.0 / kTurns, part, 1, mean);
      linearization->Gradient(part);
      backend.Axpby(1.0 / kTurns, part, 1, mean_gradient);
    }
  }
  EXPECT_LE(Distance(mean, expected), 0.05 * Norm(expected));
  EXPECT_LE(Distance(mean_gradient, gradient), 0.05 * Norm(gradient));
  // A single draw differs from the full problem.
  EXPECT_GE(Distance(part, gradient), 0.1 * Norm(gradient));
}

// A solve with each option lowers the cost.
TEST_P(SplatVariants, SolvesDescend) {
  RingProblem<float> ring(3, kCount, 1, 100);
  GetParam().apply(ring.options);
  SplatProblem<CpuBackend<float>> problem = ring.Make();
  CpuBackend<float> backend;
  vesta::LmOptions options;
  options.max_iterations = 6;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 0;
  options.column_scaling = ColumnScaling::kNone;
  options.normal_system.preconditioner = PreconditionerKind::kBlockJacobi;
  options.normal_system.pcg.max_iterations = 6;
  const LmSummary summary = SolveLm<CpuBackend<float>>(options, backend, problem, ring.x);
  EXPECT_LT(summary.final_cost, 0.95 * summary.initial_cost) << summary.FullReport();
  EXPECT_EQ(problem.Cost(ring.x), summary.final_cost);
}

}  // namespace
}  // namespace vesta::gs
