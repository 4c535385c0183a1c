// SPDX-License-Identifier: Apache-2.0
// The operators of the splatting problem agree with each other, with differences and with their columns.
#include "problems/gaussian_splatting/lm/splat_problem.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/core/check.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "solver/compose.h"
#include "solver/internal/derivative_check.inl"
#include "splatting/adam/adam.h"
#include "tests/problems/gaussian_splatting/host_vectors.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/adjoint.h"
#include "tests/support/linearize_at.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

using test::ApplyH;
using test::Distance;
using test::Norm;
using test::RandomVector;
using test::RingProblem;
using test::ToVector;

constexpr Index kCount = 30;
constexpr Index kFew = 10;  // for tests with a product per parameter
constexpr int kViews = 3;

template <class S>
constexpr double kTolerance = std::is_same_v<S, double> ? 1e-12 : 1e-5;

// v restricted to attributes [first, last] of Gaussians [begin, end).
template <class S>
HostBuffer<S> Confined(const HostBuffer<S>& v, int first, int last, Index begin, Index end) {
  HostBuffer<S> result(v.size());
  for (Index k = 0; k < v.size(); ++k) {
    const Index attribute = k / kCount, gaussian = k % kCount;
    if (attribute >= first && attribute <= last && gaussian >= begin && gaussian < end) result[k] = v[k];
  }
  return result;
}

template <class S>
class SplatProblemTest : public testing::Test {};
using Scalars = testing::Types<double, float>;
TYPED_TEST_SUITE(SplatProblemTest, Scalars);

TYPED_TEST(SplatProblemTest, ProductsWithJAreAdjoint) {
  using S = TypeParam;
  CpuBackend<S> backend;
  const RingProblem<S> ring(kViews, kCount, 3, 10);
  SplatProblem<CpuBackend<S>> problem = ring.Make();
  const auto linearization = LinearizeAt(problem, ring.x);
  EXPECT_EQ(linearization->num_residuals(), 3 * 40 * 30 * kViews);
  JacobianMap<CpuBackend<S>> J(linearization->get());
  EXPECT_LE(WorstAdjointError(backend, J, 11), kTolerance<S>);

  HostBuffer<S> u = RandomVector<S>(J.rows(), 12);
  const HostBuffer<S> v = RandomVector<S>(J.cols(), 13);
  const auto check = [&](const HostBuffer<S>& part) {
    EXPECT_LE(AdjointError<CpuBackend<S>>(backend, J, u, part), kTolerance<S>);
  };
  constexpr int kGroups[][2] = {{0, 2}, {3, 5}, {6, 9}, {10, 10}, {11, 13}, {14, 58}};
  for (const auto& [first, last] : kGroups) {
    SCOPED_TRACE(first);
    check(Confined(v, first, last, 0, kCount));
  }
  for (Index i = 0; i < kCount; ++i) {
    SCOPED_TRACE(i);
    check(Confined(v, 0, 58, i, i + 1));
  }
}

TEST(SplatProblem, JIsTheDerivativeOfTheResiduals) {
  using B = CpuBackend<double>;
  B backend;
  const RingProblem<double> ring(kViews, kCount, 2, 15);
  SplatProblem<CpuBackend<double>> problem = ring.Make();
  const HostBuffer<double> v = RandomVector<double>(problem.num_parameters(), 16);
  // So short that no pixel crosses the alpha floor; colours alone cannot.
  EXPECT_LE((TangentError<B>(backend, problem, ring.x, 0, v, 1e-8)), 1e-6);
  const HostBuffer<double> colors = Confined(v, splat::kSh, splat::kMaxAttributes, 0, kCount);
  EXPECT_LE((TangentError<B>(backend, problem, ring.x, 0, colors, 1e-4)), 1e-9);
}

TYPED_TEST(SplatProblemTest, HIsSymmetricAndPositiveSemidefinite) {
  using S = TypeParam;
  CpuBackend<S> backend;
  for (const double l1 : {0.8, 0.0}) {
    SCOPED_TRACE(l1);
    RingProblem<S> ring(kViews, kCount, 1, 22);
    ring.options.weights.l1 = l1;
    SplatProblem<CpuBackend<S>> problem = ring.Make();
    const auto linearization = LinearizeAt(problem, ring.x);
    for (std::uint64_t seed = 23; seed < 26; ++seed) {
      const HostBuffer<S> v = RandomVector<S>(problem.num_parameters(), 2 * seed);
      const HostBuffer<S> w = RandomVector<S>(problem.num_parameters(), 2 * seed + 1);
      const HostBuffer<S> Hv = ApplyH(*linearization, v), Hw = ApplyH(*linearization, w);
      EXPECT_LE(vesta::test::AdjointGap(ToVector(w), ToVector(Hv), ToVector(Hw), ToVector(v)), kTolerance<S>);
      EXPECT_GT(backend.Dot(v, Hv), 0);
      const auto i = static_cast<Index>(seed % static_cast<std::uint64_t>(kCount));
      const HostBuffer<S> one = Confined(v, 0, splat::kMaxAttributes, i, i + 1);
      EXPECT_GE(backend.Dot(one, ApplyH(*linearization, one)), 0);
    }
  }
}

TEST(SplatProblem, GradientIsTheDerivativeOfTheCost) {
  using B = CpuBackend<double>;
  B backend;
  RingProblem<double> ring(4, kCount, 2, 30);
  ring.options.batches.count = 2;
  SplatProblem<CpuBackend<double>> problem = ring.Make();
  for (std::uint64_t seed = 31; seed < 34; ++seed) {
    const HostBuffer<double> v = RandomVector<double>(problem.num_parameters(), seed);
    // Colours cross no threshold; the step of the others is too short.
    const HostBuffer<double> colors = Confined(v, splat::kSh, splat::kMaxAttributes, 0, kCount);
    EXPECT_LE((GradientError<B>(backend, problem, ring.x, colors, 1e-6)), 1e-6);
    const HostBuffer<double> geometry = Confined(v, 0, splat::kOpacity, 0, kCount);
    EXPECT_LE((GradientError<B>(backend, problem, ring.x, geometry, 1e-6)), 1e-6);
  }
}

// (H e_k)_k for every k.
std::vector<double> ExactDiagonal(LinearizationAdaptor<CpuBackend<double>>& linearization) {
  HostBuffer<double> unit(linearization.num_parameters());
  std::vector<double> exact;
  for (Index k = 0; k < unit.size(); ++k) {
    unit[k] = 1;
    exact.push_back(ApplyH(linearization, unit)[k]);
    unit[k] = 0;
  }
  return exact;
}

// Near a fit, as at the start of LM. (With errors of 0.1 and more, the SSIM part of W dominates. Single entries of wide
// splats are then up to 4 times the exact ones.)
TEST(SplatProblem, DiagonalStandsInForThatOfTheWholeLoss) {
  for (const std::uint64_t seed : {41u, 42u}) {
    SCOPED_TRACE(seed);
    RingProblem<double> ring(kViews, kFew, 1, seed);
    const SplatModel start = test::Perturbed(test::RandomModel(kFew, 1, seed), 0.02, seed);
    std::copy(start.data.begin(), start.data.end(), ring.x.begin());
    ring.options.background = {0, 0, 0};
    SplatProblem<CpuBackend<double>> problem = ring.Make();
    const auto linearization = LinearizeAt(problem, ring.x);
    HostBuffer<double> diagonal(problem.num_parameters());
    linearization->DiagJTJ(diagonal);
    const std::vector<double> exact = ExactDiagonal(*linearization);
    std::vector<double> sorted = exact;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    int compared = 0;
    for (Index k = 0; k < diagonal.size(); ++k) {
      const double value = exact[static_cast<std::size_t>(k)];
      if (value <= 1e-6 * *middle) continue;
      ++compared;
      EXPECT_GE(diagonal[k] / value, 0.3) << k;
      EXPECT_LE(diagonal[k] / value, 3) << k;
    }
    EXPECT_GT(compared, diagonal.size() * 9 / 10);
  }
}

TYPED_TEST(SplatProblemTest, CostIsTheSumOverUnits) {
  using S = TypeParam;
  const RingProblem<S> ring(4, kCount, 1, 50);
  SplatProblem<CpuBackend<S>> problem = ring.Make();
  ASSERT_EQ(problem.num_units(), 4);
  double sum = 0;
  for (Index unit = 0; unit < 4; ++unit) sum += problem.Cost(ring.x, std::span(&unit, 1));
  const double cost = problem.Cost(ring.x);
  EXPECT_GT(cost, 0);
  EXPECT_NEAR(sum, cost, 1e-14 * cost);
  const Index pair[] = {1, 3}, rest[] = {0, 2};
  EXPECT_NEAR(problem.Cost(ring.x, pair) + problem.Cost(ring.x, rest), cost, 1e-14 * cost);
}

TYPED_TEST(SplatProblemTest, CostIsThatOfTheRenderedViews) {
  using S = TypeParam;
  const RingProblem<S> ring(kViews, kCount, 1, 51);
  SplatProblem<CpuBackend<S>> problem = ring.Make();
  PhotometricLoss<S> loss(ring.options.weights);
  splat::ViewWorkspace<S> workspace;
  splat::SplatView<S> view;
  double expected = 0;
  for (const TargetView<CpuBackend<S>>& target : ring.views) {
    HostBuffer<S> image(target.truth.size());
    view.Build({ring.x.data(), kCount, 1, 1}, target.camera, ring.options.background.data(), workspace);
    view.Render(image.data());
    expected += loss.Evaluate(image, target.truth, {40, 30}).cost;
  }
  EXPECT_NEAR(problem.Cost(ring.x), expected, 1e-14 * expected);
}

TYPED_TEST(SplatProblemTest, BatchesSumToTheWhole) {
  using S = TypeParam;
  constexpr int kAll = 4;
  RingProblem<S> ring(kAll, kCount, 1, 55);
  SplatProblem<CpuBackend<S>> whole = ring.Make();
  const auto all = LinearizeAt(whole, ring.x);
  const Index n = whole.num_parameters();
  const HostBuffer<S> v = RandomVector<S>(n, 56);
  const HostBuffer<S> Hv = ApplyH(*all, v);
  HostBuffer<S> gradient(n), diagonal(n);
  all->Gradient(gradient);
  all->DiagJTJ(diagonal);
  CpuBackend<S> backend;
  // There are never more batches than views.
  for (const int batches : {2, 3, kAll, kAll + 1}) {
    SCOPED_TRACE(batches);
    ring.options.batches.count = batches;
    SplatProblem<CpuBackend<S>> problem = ring.Make();
    ASSERT_EQ(problem.num_batches(), std::min(batches, kAll));
    HostBuffer<S> sum_gradient(n), sum_diagonal(n), sum_Hv(n), part(n);
    Index residuals = 0;
    for (int b = 0; b < problem.num_batches(); ++b) {
      const auto linearization = LinearizeAt(problem, ring.x, b);
      residuals += linearization->num_residuals();
      linearization->Gradient(part);
      backend.Axpby(1, part, 1, sum_gradient);
      linearization->DiagJTJ(part);
      backend.Axpby(1, part, 1, sum_diagonal);
      backend.Axpby(1, ApplyH(*linearization, v), 1, sum_Hv);
    }
    EXPECT_EQ(residuals, all->num_residuals());
    EXPECT_LE(Distance(sum_gradient, gradient), kTolerance<S> * Norm(gradient));
    EXPECT_LE(Distance(sum_diagonal, diagonal), kTolerance<S> * Norm(diagonal));
    EXPECT_LE(Distance(sum_Hv, Hv), kTolerance<S> * Norm(Hv));
  }
}

// The reference computes the rule from the gradients of single views.
TYPED_TEST(SplatProblemTest, RightHandSideIsShrunkWhereViewsDisagreeAndTheGradientIsNot) {
  using S = TypeParam;
  constexpr double kAll = 4, kStrength = 0.3;
  RingProblem<S> ring(4, kCount, 1, 55);
  struct Both {
    HostBuffer<S> gradient, descent;
  };
  const auto slopes = [&](double strength, int batches, int batch) {
    ring.options.gradient_shrinkage = strength;
    ring.options.batches.count = batches;
    SplatProblem<CpuBackend<S>> problem = ring.Make();
    Both both{HostBuffer<S>(ring.x.size()), HostBuffer<S>(ring.x.size())};
    const auto linearization = LinearizeAt(problem, ring.x, batch);
    linearization->Gradient(both.gradient);
    EXPECT_EQ(linearization->has_own_right_hand_side(), strength > 0);
    linearization->RightHandSide(both.descent);
    return both;
  };
  std::vector<HostBuffer<S>> of_view;
  of_view.reserve(4);
  for (int view = 0; view < 4; ++view) of_view.push_back(slopes(0, 4, view).gradient);
  HostBuffer<S> expected(ring.x.size());
  int kept = 0, zero = 0;
  for (Index j = 0; j < expected.size(); ++j) {
    double sum = 0, deviations = 0;
    for (const auto& g : of_view) sum += static_cast<double>(g[j]);
    for (const auto& g : of_view) deviations += std::pow(static_cast<double>(g[j]) - sum / kAll, 2);
    const double variance = deviations * kAll / (kAll - 1);
    const double factor = sum == 0 ? 0 : std::max(0.0, 1 - kStrength * variance / (sum * sum));
    expected[j] = static_cast<S>(-factor * sum);
    kept += factor > 0.5 ? 1 : 0, zero += sum != 0 && factor == 0 ? 1 : 0;
  }
  // Both cases must occur.
  EXPECT_GT(kept, 100);
  EXPECT_GT(zero, 100);
  const Both found = slopes(kStrength, 1, 0), whole = slopes(0, 1, 0);
  EXPECT_LE(Distance(found.descent, expected), 10 * kTolerance<S> * Norm(expected));
  EXPECT_LE(Distance(found.gradient, whole.gradient), 10 * kTolerance<S> * Norm(whole.gradient));
  // With a single view there is no shrinkage.
  Both one = slopes(kStrength, 4, 2);
  EXPECT_EQ(ToVector(one.gradient), ToVector(of_view[2]));
  CpuBackend<S>().Axpby(-1, one.gradient, 0, one.gradient);
  EXPECT_EQ(ToVector(one.descent), ToVector(one.gradient));
}

TYPED_TEST(SplatProblemTest, DampingMetricIsThatOfTheRates) {
  using S = TypeParam;
  std::vector<float> units(kCount);
  for (std::size_t i = 0; i < units.size(); ++i) units[i] = 0.5f + 0.125f * static_cast<float>(i);
  RingProblem<S> ring(1, kCount, 1, 60);
  ring.options.units = std::make_shared<const std::vector<float>>(units);
  SplatProblem<CpuBackend<S>> problem = ring.Make();
  const Index n = problem.num_parameters();
  HostBuffer<S> diagonal(n), metric(n);
  std::fill(diagonal.begin(), diagonal.end(), S(7));  // only the entries of the opacities matter
  for (Index i = 0; i < kCount; ++i) diagonal[splat::kOpacity * kCount + i] = static_cast<S>(i);
  ASSERT_TRUE(problem.DampingMetric(ring.x, diagonal, metric));
  const LearningRates& rates = ring.options.lr;
  const double c = 1.2 * 0.5 * (kCount - 1) * rates.opacity * rates.opacity;
  const auto position = [&](Index i) { return units[static_cast<std::size_t>(i)] * rates.position; };
  const auto turn = [&](Index i) {  // quaternion: its rate, and the motion of the splat's ends
    double square = 0, sigma = 0;
    for (int a = splat::kQuaternion; a < splat::kOpacity; ++a) square += std::pow(ring.x[a * kCount + i], 2);
    for (int a = splat::kLogScale; a < splat::kQuaternion; ++a) {
      sigma = std::max(sigma, std::exp(static_cast<double>(ring.x[a * kCount + i])));
    }
    return 1 / std::pow(rates.quaternion, 2) + 5 / std::pow(position(i), 2) * 4 * sigma * sigma / square;
  };
  const double expected[] = {0, rates.log_scale, rates.quaternion, rates.opacity, rates.sh_dc, rates.sh_rest};
  constexpr double kFactor[] = {5, 1, 1, 1, 1, 0.02};
  constexpr int kFirst[] = {splat::kMean,    splat::kLogScale, splat::kQuaternion,
                            splat::kOpacity, splat::kSh,       splat::kSh + 3};
  for (Index k = 0; k < n; ++k) {
    const auto group = std::upper_bound(std::begin(kFirst), std::end(kFirst), k / kCount) - std::begin(kFirst) - 1;
    const Index i = k % kCount;
    const double unit = group == 2 ? turn(i) : 1 / std::pow(group == 0 ? position(i) : expected[group], 2);
    ASSERT_NEAR(metric[k] / (c * kFactor[group] * unit), 1, 1e-5) << k;
  }
}

TYPED_TEST(SplatProblemTest, DampingMetricIsLeftToTheEngineWhereThereIsNone) {
  using S = TypeParam;
  RingProblem<S> ring(1, kCount, 0, 61);
  SplatProblem<CpuBackend<S>> problem = ring.Make();
  HostBuffer<S> diagonal(problem.num_parameters()), metric(problem.num_parameters());
  metric[3] = 5;
  EXPECT_FALSE(problem.DampingMetric(ring.x, diagonal, metric)) << "the diagonal of all opacities is zero";
  std::fill(diagonal.begin(), diagonal.end(), std::numeric_limits<S>::quiet_NaN());
  EXPECT_FALSE(problem.DampingMetric(ring.x, diagonal, metric));
  ring.options.damping = LmDamping::kDiagonal;
  std::fill(diagonal.begin(), diagonal.end(), S(1));
  EXPECT_FALSE(ring.Make().DampingMetric(ring.x, diagonal, metric));
  EXPECT_EQ(metric[3], 5);
}

// A Gaussian with a non-finite parameter is ignored.
TYPED_TEST(SplatProblemTest, GaussiansThatAreNotFiniteAreLeftOut) {
  using S = TypeParam;
  constexpr Index kBad = 7;
  RingProblem<S> ring(kViews, kCount, 1, 65);
  SplatProblem<CpuBackend<S>> problem = ring.Make();
  const int attributes = splat::NumAttributes(1);
  SplatProblemOptions options = ring.options;
  options.count = kCount - 1;
  SplatProblem<CpuBackend<S>> without(options, ring.views);
  HostBuffer<S> others(attributes * options.count);
  for (Index k = 0, to = 0; k < ring.x.size(); ++k) {
    if (k % kCount != kBad) others[to++] = ring.x[k];
  }
  const double expected = without.Cost(others);
  for (const S value : {std::numeric_limits<S>::quiet_NaN(), std::numeric_limits<S>::infinity()}) {
    for (int a = 0; a < attributes; ++a) {
      if (a == splat::kOpacity && !std::isnan(value)) continue;  // opaque, but well defined
      SCOPED_TRACE(testing::Message() << "attribute " << a << " is " << value);
      HostBuffer<S> x;
      x.CopyFrom(ring.x);
      x[a * kCount + kBad] = value;
      EXPECT_EQ(problem.Cost(x), expected);
      const auto linearization = LinearizeAt(problem, x);
      HostBuffer<S> gradient(x.size());
      linearization->Gradient(gradient);
      for (Index k = 0; k < x.size(); ++k) {
        ASSERT_TRUE(std::isfinite(gradient[k]));
        ASSERT_TRUE(gradient[k] == 0 || k % kCount != kBad);
      }
    }
  }
}

TEST(SplatProblem, RefusesImagesOfAnotherSize) {
  RingProblem<float> ring(2, 3, 0, 70);
  ring.views[1].truth = ring.views[1].truth.subspan(0, 3 * 40 * 29);
  EXPECT_THROW(ring.Make(), Error);
}

TEST(SplatProblem, WithoutViewsCostsNothing) {
  SplatProblemOptions options;
  options.count = 1, options.sh_degree = 3;
  SplatProblem<CpuBackend<double>> problem(options, {});
  const HostBuffer<double> x(problem.num_parameters());
  EXPECT_EQ(problem.num_parameters(), 59);
  EXPECT_EQ(problem.Cost(x), 0);
}

}  // namespace
}  // namespace vesta::gs
