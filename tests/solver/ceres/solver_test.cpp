// SPDX-License-Identifier: Apache-2.0
// Results and ends of solves. Adapted from Ceres 2.1's tests solver_test.cc, system_test.cc,
// trust_region_minimizer_test.cc and tiny_solver_test.cc in internal/ceres. docs/ceres_tests.md lists the omitted
// cases.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "solver/residual_blocks.h"
#include "tests/solver/ceres/twin_problem.h"

namespace vesta::test {
namespace {

// target - x, for each of the two blocks or for the first alone.
struct Distance {
  double first, second;
  template <class T>
  bool operator()(const T* x, const T* y, T* r) const {
    r[0] = T(first) - x[0];
    r[1] = T(second) - y[0];
    return true;
  }
  template <class T>
  bool operator()(const T* x, T* r) const {
    r[0] = T(first) - x[0];
    return true;
  }
};

class RecordOfX final : public ceres::IterationCallback {
 public:
  explicit RecordOfX(const double* x) : x_(x) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    seen.push_back(*x_);
    return ceres::SOLVER_CONTINUE;
  }
  std::vector<double> seen;

 private:
  const double* x_;
};

class DoNothing final : public ceres::EvaluationCallback {
 public:
  void PrepareForEvaluation(bool, bool) override {}
};

// The blocks contain x during a callback if this is requested, or if there is an evaluation callback.
TEST(CeresCasesSolver, BlocksAreUpdatedEveryIteration) {
  for (const bool update : {false, true}) {
    for (const bool evaluation_callback : {false, true}) {
      for (const Way way : {Way::kCeres, Way::kBridge}) {
        SCOPED_TRACE(testing::Message() << ToString(way) << ", " << update << ", " << evaluation_callback);
        DoNothing nothing;
        TwinProblem twin(evaluation_callback ? &nothing : nullptr);
        twin.AddBlock({50});
        twin.Add<1, 1>(Distance{5, 0}, {0});
        RecordOfX record(twin.values(0));
        ceres::Solver::Options options = Quiet();
        options.update_state_every_iteration = update;
        options.callbacks.push_back(&record);
        const Solved solved = twin.Solve(way, options);
        EXPECT_NEAR(solved.x[0], 5, 1e-4);
        ASSERT_GT(record.seen.size(), 1U);
        EXPECT_EQ(record.seen[0], 50);
        const auto moved = std::count_if(record.seen.begin() + 1, record.seen.end(), [](double x) { return x != 50; });
        EXPECT_EQ(moved, update || evaluation_callback ? static_cast<int>(record.seen.size()) - 1 : 0);
      }
    }
  }
}

TEST(CeresCasesSolver, NothingToSolve) {
  for (const Way way : {Way::kCeres, Way::kBridge, Way::kNative, Way::kDefaults}) {
    SCOPED_TRACE(ToString(way));
    TwinProblem empty, unused, constant;
    unused.AddBlock({1});
    constant.AddBlock({1});
    // Residuals 4 and 5 with derivatives 0.
    const auto fixed = [](const double* const*, double* r, double** j) {
      for (int i = 0; i < 2; ++i) {
        r[i] = 4 + i;
        if (j != nullptr && j[0] != nullptr) j[0][i] = 0;
      }
      return true;
    };
    constant.Add(2, fixed, {0});
    constant.SetConstant(0);
    for (TwinProblem* twin : {&empty, &unused}) {
      const Solved solved = twin->Solve(way, Quiet());
      EXPECT_TRUE(solved.converged) << solved.report;
      EXPECT_EQ(solved.final_cost, 0);
    }
    EXPECT_EQ(unused.x()[0], 1);
    const Solved solved = constant.Solve(way, Quiet());
    EXPECT_TRUE(solved.converged) << solved.report;
    for (const double cost : {solved.initial_cost, solved.final_cost, solved.fixed_cost}) EXPECT_EQ(cost, 20.5);
    EXPECT_EQ(solved.num_iterations, 0U);
  }
}

// All tolerances are 0.
TEST(CeresCasesSolver, ABlockWithoutTangentStays) {
  TwinProblem twin;
  const int x = twin.AddBlock({0}), y = twin.AddBlock({1});
  twin.Add<2, 1, 1>(Distance{10, 5}, {x, y});
  twin.ours().SetConstant(y);
  ceres::SubsetManifold all(1, {0});
  twin.theirs().SetManifold(twin.values(y), &all);
  for (const Way way : {Way::kCeres, Way::kBridge, Way::kNative, Way::kDefaults}) {
    SCOPED_TRACE(ToString(way));
    const Solved solved = twin.Solve(way, Tolerances(0));
    EXPECT_TRUE(solved.converged) << solved.report;
    EXPECT_NEAR(solved.x[0], 10, 1e-7);
    EXPECT_EQ(solved.x[1], 1);
  }
}

constexpr ceres::LinearSolverType kLinearSolvers[] = {
    ceres::DENSE_QR,    ceres::DENSE_NORMAL_CHOLESKY, ceres::SPARSE_NORMAL_CHOLESKY,
    ceres::DENSE_SCHUR, ceres::SPARSE_SCHUR,          ceres::ITERATIVE_SCHUR,
    ceres::CGNR};

TEST(CeresCasesSolver, EveryLinearSolverHasOptions) {
  for (const ceres::LinearSolverType type : kLinearSolvers) {
    SCOPED_TRACE(ceres::LinearSolverTypeToString(type));
    std::string message;
    EXPECT_TRUE(Quiet(type).IsValid(&message)) << message;
    EXPECT_NO_THROW(ceres_bridge::FromCeres(Quiet(type)).Validate());
  }
}

// Powell's singular function from (3, -1, 0, 1), with the minimum 0 at x = 0. Source: More, Garbow, Hillstrom, Testing
// unconstrained optimization software, 1981, problem 13. Residual k depends on the blocks of kPairs[k].
constexpr std::array<std::array<int, 2>, 4> kPairs = {{{0, 1}, {2, 3}, {1, 2}, {0, 3}}};
template <int k>
struct Powell {
  template <class T>
  bool operator()(const T* a, const T* b, T* r) const {
    if constexpr (k == 0) r[0] = a[0] + T(10.0) * b[0];
    if constexpr (k == 1) r[0] = T(std::sqrt(5.0)) * (a[0] - b[0]);
    if constexpr (k == 2) r[0] = (a[0] - T(2.0) * b[0]) * (a[0] - T(2.0) * b[0]);
    if constexpr (k == 3) r[0] = T(std::sqrt(10.0)) * (a[0] - b[0]) * (a[0] - b[0]);
    return true;
  }
};

// Blocks whose bit in `active` is not set are constant at their minimum, 0.
struct PowellProblem : TwinProblem {
  explicit PowellProblem(unsigned active = 15) {
    constexpr double kStart[] = {3, -1, 0, 1};
    for (int k = 0; k < 4; ++k) {
      AddBlock({(active >> k & 1U) != 0 ? kStart[k] : 0});
      if ((active >> k & 1U) == 0) SetConstant(k);
    }
    const auto blocks = [](std::size_t k) { return std::vector<int>(kPairs[k].begin(), kPairs[k].end()); };
    Add<1, 1, 1>(Powell<0>(), blocks(0));
    Add<1, 1, 1>(Powell<1>(), blocks(1));
    Add<1, 1, 1>(Powell<2>(), blocks(2));
    Add<1, 1, 1>(Powell<3>(), blocks(3));
  }
  std::array<double, 4> Residuals(const std::vector<double>& x) const {
    std::array<double, 4> r{};
    const auto residual = [&]<int k>(Powell<k> f) {
      f(&x.at(static_cast<std::size_t>(kPairs[k][0])), &x.at(static_cast<std::size_t>(kPairs[k][1])), &r[k]);
    };
    residual(Powell<0>()), residual(Powell<1>()), residual(Powell<2>()), residual(Powell<3>());
    return r;
  }
};

// After at most 10 iterations, every linear solver has the same residuals as Ceres's dense QR. CGNR is not accurate
// enough for this, in Ceres too.
TEST(CeresCasesSystem, PowellsFunctionWithEveryLinearSolver) {
  PowellProblem powell;
  ceres::Solver::Options options = Quiet();
  options.max_num_iterations = 10;
  const std::array<double, 4> expected = powell.Residuals(powell.Solve(Way::kCeres, options).x);
  for (const ceres::LinearSolverType type : kLinearSolvers) {
    if (type == ceres::CGNR) continue;
    options.linear_solver_type = type;
    for (const Way way : {Way::kBridge, Way::kNative}) {
      SCOPED_TRACE(testing::Message() << ceres::LinearSolverTypeToString(type) << ", " << ToString(way));
      const Solved solved = powell.Solve(way, options);
      const std::array<double, 4> residuals = powell.Residuals(solved.x);
      for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(residuals[k], expected[k], 1e-8) << solved.report;
    }
  }
}

// Every subset of the parameters finds the minimum, except {0, 1, 3}, which ends at a local minimum in Ceres too.
TEST(CeresCasesTrustRegion, PowellsFunctionOfEverySubset) {
  ceres::Solver::Options options = Tolerances(1e-26);
  options.max_trust_region_radius = 1e20;
  for (unsigned active = 1; active < 16; ++active) {
    if (active == (1U | 2U | 8U)) continue;
    PowellProblem powell(active);
    for (const Way way : kOurWays) {
      SCOPED_TRACE(testing::Message() << active << ", " << ToString(way));
      const Solved solved = powell.Solve(way, options);
      for (const double x : solved.x) EXPECT_NEAR(x, 0, 1e-3) << solved.report;
    }
  }
}

// One residual: 10 minus the perimeter of a polygon, which starts as the regular hexagon with radius 1.
TEST(CeresCasesTrustRegion, PerimeterOfAHexagon) {
  constexpr int kVertices = 6;
  TwinProblem twin;
  std::vector<int> blocks;
  blocks.reserve(kVertices);
  for (int i = 0; i < kVertices; ++i) {
    const double angle = 2 * std::numbers::pi * i / kVertices;
    blocks.push_back(twin.AddBlock({std::cos(angle), std::sin(angle)}));
  }
  const auto perimeter = [](const double* const* p, double* r, double** j) {
    r[0] = 10;
    for (int i = 0; j != nullptr && i < kVertices; ++i) {
      if (j[i] != nullptr) j[i][0] = j[i][1] = 0;
    }
    for (int i = 0; i < kVertices; ++i) {
      const int next = (i + 1) % kVertices;
      const double edge[] = {p[next][0] - p[i][0], p[next][1] - p[i][1]};
      const double length = std::hypot(edge[0], edge[1]);
      r[0] -= length;
      for (int k = 0; j != nullptr && length > 0 && k < 2; ++k) {
        if (j[i] != nullptr) j[i][k] += edge[k] / length;
        if (j[next] != nullptr) j[next][k] -= edge[k] / length;
      }
    }
    return true;
  };
  twin.Add(1, perimeter, blocks);
  for (const Way way : {Way::kCeres, Way::kBridge, Way::kNative, Way::kDefaults}) {
    SCOPED_TRACE(ToString(way));
    const Solved solved = twin.Solve(way, Quiet());
    EXPECT_TRUE(solved.converged);
    EXPECT_LE(solved.final_cost, 1e-10) << solved.report;
  }
}

struct TenMinusExp {
  template <class T>
  bool operator()(const T* x, T* r) const {
    using std::exp;
    r[0] = T(10.0) - exp(x[0]);
    return true;
  }
};

// The solve ends by the gradient tolerance at a bound; the last step counts.
TEST(CeresCasesTrustRegion, ConvergesAtABound) {
  TwinProblem twin;
  twin.AddBlock({5});
  twin.Add<1, 1>(TenMinusExp(), {0});
  twin.SetBounds(0, 0, 3, std::numeric_limits<double>::max());
  twin.ours().SetBounds(0, 0, 3, std::numeric_limits<double>::infinity());
  for (const Way way : {Way::kCeres, Way::kBridge, Way::kNative, Way::kDefaults}) {
    SCOPED_TRACE(ToString(way));
    const Solved solved = twin.Solve(way, Quiet());
    EXPECT_TRUE(solved.converged) << solved.report;
    EXPECT_NEAR(solved.x[0], 3, 1e-12);
    EXPECT_NEAR(solved.final_cost, 0.5 * std::pow(10 - std::exp(3.0), 2), 1e-12);
  }
}

// Two residuals of three parameters, a plane and a product, from a distant start.
struct PlaneAndProduct {
  static constexpr int kResiduals = 2, kParameters = 3;
  template <class T>
  bool operator()(const T* p, T* r) const {
    r[0] = p[0] + T(2.0) * p[1] + T(4.0) * p[2];
    r[1] = p[1] * p[2];
    return true;
  }
};
// Two planes through (1, 2, 3).
struct TwoPlanes {
  static constexpr int kResiduals = 2, kParameters = 3;
  template <class T>
  bool operator()(const T* p, T* r) const {
    const T a = p[0] - T(1.0), b = p[1] - T(2.0), c = p[2] - T(3.0);
    r[0] = a + T(2.0) * b + T(4.0) * c;
    r[1] = T(5.0) * a + b + T(3.0) * c;
    return true;
  }
};

// Sizes known at compile time (ResidualBlocks, AutoDiffCost) and at run time (OurFunction). The functors have fewer
// residuals than parameters.
template <class F>
void ExpectZero(const std::vector<double>& start) {
  const F functor;
  const ceres::Solver::Options options = Tolerances(1e-13);
  const auto residual_norm = [&](const std::vector<double>& x) {
    double r[2];
    functor(x.data(), r);
    return std::hypot(r[0], r[1]);
  };
  ASSERT_GT(residual_norm(start), 1e-10);
  TwinProblem fixed, dynamic;
  fixed.AddBlock(start);
  fixed.Add<2, 3>(functor, {0});
  dynamic.AddBlock(start);
  const auto cost = std::make_shared<AutoDiffCost<F, 2, 3>>(functor);
  dynamic.Add(2, [cost](const double* const* p, double* r, double** j) { return cost->Evaluate(p, r, j); }, {0});
  for (const Way way : kOurWays) {
    SCOPED_TRACE(ToString(way));
    EXPECT_NEAR(residual_norm(fixed.Solve(way, options).x), 0, 1e-10);
    EXPECT_NEAR(residual_norm(dynamic.Solve(way, options).x), 0, 1e-10);
  }
  ResidualBlocks<F, CpuBackend<double>> blocks(3, {functor});
  std::vector<double> x = start;
  const LmSummary summary = SolveLm(blocks, x, ceres_bridge::FromCeres(options));
  EXPECT_NEAR(residual_norm(x), 0, 1e-10) << summary.FullReport();
}

TEST(CeresCasesTinySolver, FewerResidualsThanParameters) {
  ExpectZero<PlaneAndProduct>({0.76026643, -30.01799744, 0.55192142});
  ExpectZero<TwoPlanes>({2, -3, 6});
}

}  // namespace
}  // namespace vesta::test
