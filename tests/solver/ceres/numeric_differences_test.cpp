// SPDX-License-Identifier: Apache-2.0
// Numeric derivatives. Adapted from Ceres 2.1's test numeric_diff_cost_function_test.cc in internal/ceres.
// docs/ceres_tests.md lists the omitted cases.
#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "solver/cost_function.h"
#include "tests/solver/ceres/cost_derivatives.h"

namespace vesta::test {
namespace {

// Two blocks of 5: x^T y, its square, and |y|^2.
struct Products {
  template <class T>
  bool operator()(const T* x, const T* y, T* r) const {
    r[0] = r[2] = T(0.0);
    for (int i = 0; i < 5; ++i) r[0] += x[i] * y[i], r[2] += y[i] * y[i];
    r[1] = r[0] * r[0];
    return true;
  }
};
struct Transcendental {
  template <class T>
  bool operator()(const T* x, const T* y, T* r) const {
    using std::exp, std::sin;
    T dot = T(0.0);
    for (int i = 0; i < 5; ++i) dot += x[i] * y[i];
    r[0] = sin(dot);
    r[1] = exp(-dot / T(10.0));
    return true;
  }
};

// Differentiates another cost function numerically. The sizes are known at run time.
class Wrapped final : public NumericDifferences {
 public:
  Wrapped(std::shared_ptr<const CostFunction> cost, const DifferenceOptions& options)
      : NumericDifferences(cost->num_residuals(), SizesOf(*cost), options), cost_(std::move(cost)) {}

 protected:
  bool Residuals(const double* const* p, double* r) const override { return cost_->Evaluate(p, r, nullptr); }

 private:
  std::shared_ptr<const CostFunction> cost_;
};

template <class F, int kResiduals>
void ExpectDifferences(const Blocks& at, DifferenceMethod method, double tolerance) {
  const auto exact = std::make_shared<AutoDiffCost<F, kResiduals, 5, 5>>();
  const DifferenceOptions options{.method = method};
  EXPECT_EQ(options.relative_step, ceres::NumericDiffOptions().relative_step_size);
  EXPECT_EQ(options.least_step, std::sqrt(std::numeric_limits<double>::epsilon())) << "as in Ceres";
  const NumericDiffCost<F, kResiduals, 5, 5> of_functor(F(), options);
  const Wrapped of_cost(exact, options);
  for (const NumericDifferences* cost :
       {static_cast<const NumericDifferences*>(&of_functor), static_cast<const NumericDifferences*>(&of_cost)}) {
    for (unsigned wanted = 0; wanted < 4; ++wanted) {
      ExpectNear(Evaluate<CostFunction>(*cost, at, wanted), Evaluate<CostFunction>(*exact, at, wanted), tolerance);
    }
  }
}

TEST(CeresCasesNumericDiff, CentralAndForwardDifferences) {
  const Blocks near_zero = {{1e-64, 2, 3, 4, 5}, {9, 9, 5, 5, 1}};
  ExpectDifferences<Products, 3>(near_zero, DifferenceMethod::kCentral, 3e-9);
  ExpectDifferences<Products, 3>(near_zero, DifferenceMethod::kForward, 2e-5);
  const std::vector<double> x = {1, 2, 3, 4, 5}, y = {9, 9, 5, 5, 1}, zero(5);
  for (const Blocks& at : {Blocks{x, y}, Blocks{{0, 2, 3, 0, 5}, y}, Blocks{{1, 2, 3, 1, 5}, {0, 9, 0, 5, 0}},
                           Blocks{zero, y}, Blocks{x, zero}, Blocks{zero, zero}}) {
    ExpectDifferences<Transcendental, 2>(at, DifferenceMethod::kCentral, 2e-7);
    ExpectDifferences<Transcendental, 2>(at, DifferenceMethod::kForward, 2e-5);
  }
}

// The largest error of the derivatives of a cost function of one block, relative to max(1, |exact|).
template <class Cost>
double WorstError(const Cost& cost, const CostFunction& exact, const Blocks& at) {
  const Derivatives found = Evaluate(cost, at), expected = Evaluate(exact, at);
  double worst = 0;
  for (std::size_t b = 0; b < expected.jacobians.size(); ++b) {
    for (std::size_t i = 0; i < expected.jacobians[b].size(); ++i) {
      const double size = std::max(1.0, std::abs(expected.jacobians[b][i]));
      worst = std::max(worst, std::abs(found.jacobians[b][i] - expected.jacobians[b][i]) / size);
    }
  }
  return worst;
}

// Ridders' method has errors up to `tolerance` here and in Ceres. smooth: the functor without noise.
template <int kResiduals, int... kSizes, class F, class Smooth>
void ExpectRidders(const F& functor, const Smooth& smooth, const Blocks& at, double step, double tolerance) {
  const AutoDiffCost<Smooth, kResiduals, kSizes...> exact(smooth);
  const auto cost = std::make_shared<AutoDiffCost<F, kResiduals, kSizes...>>(functor);
  const DifferenceOptions options = {.method = DifferenceMethod::kRidders, .ridders_step = step};
  ceres::NumericDiffOptions their_options;
  their_options.ridders_relative_initial_step_size = step;
  const ceres::NumericDiffCostFunction<F, ceres::RIDDERS, kResiduals, kSizes...> theirs(
      new F(functor), ceres::TAKE_OWNERSHIP, kResiduals, their_options);
  EXPECT_LE(WorstError<CostFunction>(NumericDiffCost<F, kResiduals, kSizes...>(functor, options), exact, at),
            tolerance);
  EXPECT_LE(WorstError<CostFunction>(Wrapped(cost, options), exact, at), tolerance);
  EXPECT_LE(WorstError(theirs, exact, at), tolerance);
}

struct Exponential {
  template <class T>
  bool operator()(const T* x, T* r) const {
    using std::exp;
    r[0] = exp(x[0]);
    return true;
  }
};

// x^2 with noise of this size.
struct Noisy {
  double noise;
  template <class T>
  bool operator()(const T* x, T* r) const {
    using std::sin;
    r[0] = x[0] * x[0] + T(noise) * sin(T(1e12) * x[0]);
    return true;
  }
};

// The first steps are as in Ceres's tests: short for a function that oscillates, long for a function with noise.
TEST(CeresCasesNumericDiff, Ridders) {
  ExpectRidders<3, 5, 5>(Products(), Products(), {{1e-64, 2, 3, 4, 5}, {9, 9, 5, 5, 1}}, 1e-2, 1e-11);
  const std::vector<double> x = {1, 2, 3, 4, 5}, y = {9, 9, 5, 5, 1}, zero(5);
  for (const Blocks& at : {Blocks{x, y}, Blocks{{0, 2, 3, 0, 5}, y}, Blocks{{1, 2, 3, 1, 5}, {0, 9, 0, 5, 0}},
                           Blocks{zero, y}, Blocks{x, zero}, Blocks{zero, zero}}) {
    ExpectRidders<2, 5, 5>(Transcendental(), Transcendental(), at, 1e-3, 1e-10);
  }
  for (int k = -3; k <= 3; ++k) ExpectRidders<1, 1>(Exponential(), Exponential(), {{k * std::log(2.0)}}, 1e-2, 1e-10);
  for (const double at : {0.0, 1.0, 3.0, 4.0, 50.0}) ExpectRidders<1, 1>(Noisy{1e-9}, Noisy{0}, {{at}}, 10, 1e-6);
}

}  // namespace
}  // namespace vesta::test
