// SPDX-License-Identifier: Apache-2.0
// SmallSolver: known answers, the decisions of SolveLm, the minima of ceres::TinySolver, and bad input.
#include "solver/small_solver.h"

#include <ceres/tiny_solver.h>
#include <ceres/tiny_solver_autodiff_function.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "kernels/core/parallel.h"
#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"
#include "solver/solve_each.h"
#include "tests/solver/small_functors.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

LmOptions Tight() {
  LmOptions options;
  options.function_tolerance = 1e-14;
  options.parameter_tolerance = 1e-12;
  options.gradient_tolerance = 1e-16;
  options.max_iterations = 200;
  return options;
}

template <class F, std::size_t N>
SmallSummary Solve(const F& functor, std::array<double, N>& x, const LmOptions& options = {}) {
  return SmallSolver<F>(options).Solve(functor, x);
}

// Solves by SolveLm and by SmallSolver. Both must take and reject the same steps.
template <class F, std::size_t N>
void ExpectSameDecisions(const F& functor, const std::array<double, N>& start, const LmOptions& options,
                         double tolerance) {
  std::array<double, N> x = start, expected = start;
  const SmallSummary summary = Solve(functor, x, options);
  ResidualBlocks<F, CpuBackend<double>> problem(static_cast<Index>(N), {functor});
  const LmSummary engine = SolveLm(problem, std::span<double>(expected), options);
  EXPECT_EQ(summary.status, engine.status) << engine.BriefReport();
  EXPECT_EQ(summary.num_accepted, engine.num_accepted);
  EXPECT_EQ(summary.num_rejected, engine.num_rejected);
  EXPECT_NEAR(summary.initial_cost, engine.initial_cost, 1e-14 * engine.initial_cost);
  EXPECT_NEAR(summary.final_cost, engine.final_cost, 1e-12 * (engine.initial_cost + 1));
  for (std::size_t k = 0; k < N; ++k) EXPECT_NEAR(x[k], expected[k], tolerance) << k;
}

TEST(SmallSolver, DecidesAsTheEngine) {
  const std::vector<double> y = DecayBatch::Readings({3, 0.7, 0.2}, 0.05, 1);
  const DecayBatch batch;
  const ProblemOfBatch<DecayBatch> decay(batch, y.data());
  ExpectSameDecisions(decay, std::array{1.0, 1.0, 0.0}, {}, 1e-9);
  ExpectSameDecisions(decay, std::array{1.0, 1.0, 0.0}, Tight(), 1e-10);
  ExpectSameDecisions(decay, std::array{-20.0, 5.0, 8.0}, {}, 1e-8);
  ExpectSameDecisions(Rosenbrock(), std::array{-1.2, 1.0}, {}, 1e-9);  // rejects steps
  ExpectSameDecisions(Powell(), std::array{3.0, -1.0, 0.0, 1.0}, {}, 1e-6);
  ExpectSameDecisions(UnusedParameter(), std::array{3.0, 5.0}, {}, 1e-10);
  for (const ColumnScaling scaling : {ColumnScaling::kNone, ColumnScaling::kOnePlusInverse}) {
    LmOptions options;
    options.column_scaling = scaling;
    ExpectSameDecisions(Rosenbrock(), std::array{-1.2, 1.0}, options, 1e-9);
  }
  LmOptions limited;
  limited.max_iterations = 3;
  ExpectSameDecisions(Rosenbrock(), std::array{-1.2, 1.0}, limited, 1e-9);
  limited.max_iterations = 50;
  limited.SetStepRule(StepRule::k3dgsLmV2);
  ExpectSameDecisions(Rosenbrock(), std::array{-1.2, 1.0}, limited, 1e-9);
}

TEST(SmallSolver, FindsKnownMinima) {
  std::array x{-1.2, 1.0};
  EXPECT_TRUE(IsConverged(Solve(Rosenbrock(), x, Tight()).status));
  for (const double value : x) EXPECT_NEAR(value, 1, 1e-12);
  // Normal equations of a Jacobian of condition 1e6 would leave an error of about 1e-4.
  std::array<double, 8> coefficients{};
  const SmallSummary summary = Solve(Monomials(), coefficients, Tight());
  EXPECT_TRUE(IsConverged(summary.status)) << ToString(summary.status);
  for (const double value : coefficients) EXPECT_NEAR(value, 1, 1e-8);
}

TEST(SmallSolver, FindsTheMinimaOfTinySolver) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const std::vector<double> y = DecayBatch::Readings({2, 0.5 + 0.05 * static_cast<double>(seed), 0.5}, 0.02, seed);
    const DecayBatch batch;
    std::array x{1.0, 1.0, 0.0};
    Solve(ProblemOfBatch<DecayBatch>(batch, y.data()), x, Tight());
    const auto functor = [&](const auto* p, auto* r) {
      batch(y.data(), p, r);
      return true;
    };
    using Function = ceres::TinySolverAutoDiffFunction<decltype(functor), DecayBatch::kResiduals, 3>;
    const Function function(functor);
    ceres::TinySolver<Function> tiny;
    tiny.options.function_tolerance = tiny.options.cost_threshold = 0;
    tiny.options.parameter_tolerance = 1e-13;
    Eigen::Vector3d expected(1, 1, 0);
    tiny.Solve(function, &expected);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(x[static_cast<std::size_t>(k)], expected[k], 1e-8) << seed;
  }
}

// sum_k (a_ik p_k) - b_i with a known solution; more parameters than derivatives fit into one pass.
struct Wide {
  static constexpr int kResiduals = 40, kParameters = 30;
  template <class T>
  void operator()(const T* p, T* r) const {
    for (int i = 0; i < kResiduals; ++i) {
      T sum(0.0);
      for (int k = 0; k < kParameters; ++k) sum = sum + T(std::sin(1 + i * k + 0.3 * k)) * (p[k] - T(0.1 * k));
      r[i] = sum;
    }
  }
};

TEST(SmallSolver, TakesManyParametersInSeveralPasses) {
  std::array<double, 30> x{};
  EXPECT_TRUE(IsConverged(Solve(Wide(), x, Tight()).status));
  for (std::size_t k = 0; k < x.size(); ++k) EXPECT_NEAR(x[k], 0.1 * static_cast<double>(k), 1e-9);
}

// sqrt(2) by a functor that is no template.
struct RootOfTwo {
  static constexpr int kResiduals = 1, kParameters = 1;
  void operator()(const double* p, double* r) const { r[0] = p[0] * p[0] - 2; }
  void operator()(const Dual<double>* p, Dual<double>* r) const { r[0] = p[0] * p[0] - Dual<double>(2.0); }
};

TEST(SmallSolver, TakesFunctorsOfOneDerivative) {
  std::array x{1.0};
  Solve(RootOfTwo(), x, Tight());
  EXPECT_NEAR(x[0], std::sqrt(2.0), 1e-13);
}

struct RootOfTwoInFloat {
  static constexpr int kResiduals = 2, kParameters = 2;
  template <class T>
  void operator()(const T* p, T* r) const {
    r[0] = p[0] * p[0] - T(2.0F);
    r[1] = p[0] * p[1] - T(2.0F);
  }
};

TEST(SmallSolver, SolvesInFloat) {
  std::array x{1.0F, 1.0F};
  LmOptions options;
  options.parameter_tolerance = 1e-4;
  const SmallSummary summary = SmallSolver<RootOfTwoInFloat, float>(options).Solve({}, x);
  EXPECT_TRUE(IsConverged(summary.status)) << ToString(summary.status);
  for (const float value : x) EXPECT_NEAR(value, std::sqrt(2.0F), 1e-5F);
}

// The mean of some readings.
struct Mean {
  static constexpr int kResiduals = kResidualsAtRunTime, kParameters = 1;
  std::vector<double> readings;
  int count = 0;
  int num_residuals() const { return count; }
  template <class T>
  void operator()(const T* p, T* r) const {
    for (std::size_t i = 0; i < readings.size(); ++i) r[i] = p[0] - T(readings[i]);
  }
};

TEST(SmallSolver, TakesResidualCountsAtRunTime) {
  const SmallSolver<Mean> solver(Tight());
  SmallSolver<Mean>::Workspace workspace;
  for (const std::vector<double>& readings : {std::vector<double>{1, 2, 6}, {5}, {1, 2, 3, 4, 5}, {}}) {
    std::array x{-7.0};
    const SmallSummary summary = solver.Solve({readings, static_cast<int>(readings.size())}, x, workspace);
    EXPECT_TRUE(IsConverged(summary.status));
    EXPECT_NEAR(x[0], readings.empty() ? -7 : readings.size() == 1 ? 5 : 3, 1e-9);
  }
  std::array x{0.0};
  EXPECT_THAT([&] { solver.Solve({{}, -1}, x); }, ThrowsError(kBadArgument, "-1"));
}

TEST(SmallSolver, ServesManyThreads) {
  const SmallSolver<Rosenbrock> solver(Tight());
  std::vector<std::array<double, 2>> x(200, {-1.2, 1.0});
  ParallelFor(200, 1, [&](Index i) { solver.Solve({}, x[static_cast<std::size_t>(i)]); });
  for (const auto& result : x) EXPECT_EQ(result, x[0]);
}

// log(p) = 1 with bool results: undefined for p <= 0.
struct Logarithm {
  static constexpr int kResiduals = 1, kParameters = 1;
  template <class T>
  bool operator()(const T* p, T* r) const {
    using std::log;
    if (p[0] <= T(0.0)) return false;
    r[0] = log(p[0]) - T(1.0);
    return true;
  }
};

// Writes only r[0].
struct Forgetful {
  static constexpr int kResiduals = 2, kParameters = 1;
  template <class T>
  void operator()(const T* p, T* r) const {
    r[0] = p[0];
  }
};

// The derivative at 0 is infinite.
struct SquareRoot {
  static constexpr int kResiduals = 1, kParameters = 1;
  template <class T>
  void operator()(const T* p, T* r) const {
    using std::sqrt;
    r[0] = sqrt(p[0]) - T(1.0);
  }
};

TEST(SmallSolver, ReportsWhatCannotBeSolved) {
  std::array x{20.0};  // the first step leads to a negative p
  SmallSummary summary = Solve(Logarithm(), x, Tight());
  EXPECT_TRUE(IsConverged(summary.status)) << ToString(summary.status);
  EXPECT_GT(summary.num_rejected, 0);
  EXPECT_NEAR(x[0], std::exp(1.0), 1e-10);
  x = {-1};
  EXPECT_EQ(Solve(Logarithm(), x).status, LmStatus::kNonFinite);
  EXPECT_EQ(x[0], -1);
  x = {1};
  EXPECT_EQ(Solve(Forgetful(), x).status, LmStatus::kNonFinite);
  x = {std::numeric_limits<double>::quiet_NaN()};
  EXPECT_EQ(Solve(RootOfTwo(), x).status, LmStatus::kNonFinite);
  x = {0};
  EXPECT_EQ(Solve(SquareRoot(), x).status, LmStatus::kNonFinite);
  LmOptions options;
  options.max_iterations = 0;
  x = {1};
  EXPECT_EQ(Solve(RootOfTwo(), x, options).status, LmStatus::kMaxIterations);
  EXPECT_EQ(x[0], 1);
  options.max_iterations = 10;
  options.max_seconds = 0;
  EXPECT_EQ(Solve(RootOfTwo(), x, options).status, LmStatus::kTimeLimit);
  EXPECT_EQ(x[0], 1);
}

TEST(SmallSolver, RefusesOptionsWithoutEffect) {
  const auto refuses = [](const std::function<void(LmOptions&)>& set, ErrorCode code) {
    LmOptions options;
    set(options);
    EXPECT_THAT([&] { SmallSolver<Rosenbrock>{options}; }, ThrowsError(code));
  };
  refuses([](LmOptions& o) { o.line_search.enabled = true; }, kUnsupported);
  refuses([](LmOptions& o) { o.batch_mode = BatchMode::kMerge; }, kUnsupported);
  refuses([](LmOptions& o) { o.check_derivatives = true; }, kUnsupported);
  refuses([](LmOptions& o) { o.profile = true; }, kUnsupported);
  refuses([](LmOptions& o) { o.normal_system.linear_solver = LinearSolverKind::kPcg; }, kUnsupported);
  refuses([](LmOptions& o) { o.normal_system.metric.group_median_floor = 1; }, kUnsupported);
  refuses([](LmOptions& o) { o.function_tolerance = -1; }, kBadArgument);
}

}  // namespace
}  // namespace vesta
