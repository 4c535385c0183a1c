// SPDX-License-Identifier: Apache-2.0
// Behaviour of ceres::Solve beyond the minimum: the bridge behaves like ceres::Solve.
#include "solver/ceres/ceres_solve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "solver/ceres/ceres_problem.h"

namespace vesta {
namespace {

using ceres_bridge::Solve;

// Rosenbrock's valley with its two coordinates as separate blocks.
struct Valley {
  template <class T>
  bool operator()(const T* x, const T* y, T* r) const {
    r[0] = T(10.0) * (y[0] - x[0] * x[0]);
    r[1] = T(1.0) - x[0];
    return true;
  }
};

struct Rosenbrock {
  Rosenbrock() {
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Valley, 2, 1, 1>(new Valley), nullptr, &x, &y);
  }
  double Cost() {
    double cost = 0;
    problem.Evaluate({}, &cost, nullptr, nullptr, nullptr);
    return cost;
  }
  double x = -1.2, y = 1;
  ceres::Problem problem;
};

ceres::Solver::Options Quiet() {
  ceres::Solver::Options options;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 100;
  return options;
}

class Recorder final : public ceres::IterationCallback {
 public:
  explicit Recorder(Rosenbrock& problem) : problem_(problem) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& row) override {
    rows.push_back(row);
    costs_of_blocks.push_back(problem_.Cost());
    return row.iteration == stop_at ? answer : ceres::SOLVER_CONTINUE;
  }
  int stop_at = -1;
  ceres::CallbackReturnType answer = ceres::SOLVER_CONTINUE;
  std::vector<ceres::IterationSummary> rows;
  std::vector<double> costs_of_blocks;

 private:
  Rosenbrock& problem_;
};

bool HasNote(const LmSummary& summary, const std::string& text) {
  for (const std::string& note : summary.notes) {
    if (note.find(text) != std::string::npos) return summary.FullReport().find("note: " + note) != std::string::npos;
  }
  return false;
}

TEST(CeresSolve, ProjectsAnInfeasibleStartAsCeresDoes) {
  Rosenbrock ours, theirs;
  for (Rosenbrock* one : {&ours, &theirs}) {
    one->problem.SetParameterUpperBound(&one->x, 0, 0.5);
    one->problem.SetParameterLowerBound(&one->x, 0, -1);
    one->x = 3;
  }
  ceres::Solver::Summary expected;
  ceres::Solve(Quiet(), &theirs.problem, &expected);
  ASSERT_EQ(expected.termination_type, ceres::CONVERGENCE);
  const LmSummary summary = Solve(Quiet(), ours.problem);
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  EXPECT_NEAR(ours.x, theirs.x, 1e-8);
  EXPECT_NEAR(summary.initial_cost, 0.5 * (100 * (1 - 0.25) * (1 - 0.25) + 0.25), 1e-12);
  EXPECT_TRUE(HasNote(summary, "projected onto the bounds"));
  ours.x = 3;
  EXPECT_TRUE(IsConverged(Solve(LmOptions(), ours.problem).status)) << "with vesta's options too";
  ours.x = 0.2;
  EXPECT_FALSE(HasNote(Solve(Quiet(), ours.problem), "projected"));
}

TEST(CeresSolve, RefusesAConstantBlockOutsideItsBoundsAsCeresDoes) {
  Rosenbrock ours, theirs;
  for (Rosenbrock* one : {&ours, &theirs}) {
    one->problem.SetParameterBlockConstant(&one->y);
    one->problem.SetParameterUpperBound(&one->y, 0, 0.5);
  }
  ceres::Solver::Summary expected;
  ceres::Solve(Quiet(), &theirs.problem, &expected);
  EXPECT_EQ(expected.termination_type, ceres::FAILURE);
  const LmSummary summary = Solve(Quiet(), ours.problem);
  EXPECT_EQ(summary.status, LmStatus::kInfeasible);
  EXPECT_NE(summary.message.find("constant, and its entry 0 is 1, outside of ["), std::string::npos) << summary.message;
  EXPECT_EQ(ours.x, -1.2);
  // Equal bounds of a constant block do not matter, as in Ceres.
  ours.problem.SetParameterUpperBound(&ours.y, 0, 1);
  ours.problem.SetParameterLowerBound(&ours.y, 0, 1);
  EXPECT_TRUE(IsConverged(Solve(Quiet(), ours.problem).status));
}

TEST(CeresSolve, CallsTheCallbacksAsCeresDoes) {
  Rosenbrock ours, theirs;
  Recorder ours_seen(ours), theirs_seen(theirs);
  for (const bool update : {true, false}) {
    ours.x = theirs.x = -1.2;
    ours.y = theirs.y = 1;
    const auto options = [&](Recorder& recorder) {
      recorder.rows.clear();
      recorder.costs_of_blocks.clear();
      ceres::Solver::Options made = Quiet();
      made.linear_solver_type = ceres::DENSE_QR;
      made.callbacks.push_back(&recorder);
      made.update_state_every_iteration = update;
      return made;
    };
    ceres::Solver::Summary expected;
    ceres::Solve(options(theirs_seen), &theirs.problem, &expected);
    const LmSummary summary = Solve(options(ours_seen), ours.problem);
    ASSERT_EQ(ours_seen.rows.size(), summary.iterations.size());
    ASSERT_GE(theirs_seen.rows.size(), 10U);
    // Both solvers take the same steps, so their reports agree.
    for (std::size_t i = 0; i < 10; ++i) {
      const ceres::IterationSummary &a = ours_seen.rows[i], &b = theirs_seen.rows[i];
      EXPECT_EQ(a.iteration, b.iteration);
      EXPECT_EQ(a.step_is_successful, b.step_is_successful) << i;
      EXPECT_EQ(a.step_is_valid, b.step_is_valid) << i;
      if (b.step_is_successful) {
        EXPECT_NEAR(a.cost, b.cost, 1e-6 * b.cost) << i;
      }
      EXPECT_NEAR(a.trust_region_radius, b.trust_region_radius, 1e-4 * b.trust_region_radius) << i;
      EXPECT_NEAR(a.relative_decrease, b.relative_decrease, 1e-4 * std::abs(b.relative_decrease)) << i;
      EXPECT_NEAR(ours_seen.costs_of_blocks[i], theirs_seen.costs_of_blocks[i], 1e-6 * b.cost + 1e-12) << i;
    }
    EXPECT_EQ(ours_seen.costs_of_blocks.front() == ours_seen.costs_of_blocks.back(), !update);
  }
}

TEST(CeresSolve, ACallbackMayEndItAndAbortLeavesTheBlocks) {
  for (const auto answer : {ceres::SOLVER_TERMINATE_SUCCESSFULLY, ceres::SOLVER_ABORT}) {
    Rosenbrock ours;
    Recorder recorder(ours);
    recorder.stop_at = 6;
    recorder.answer = answer;
    ceres::Solver::Options options = Quiet();
    options.callbacks.push_back(&recorder);
    const LmSummary summary = Solve(options, ours.problem);
    EXPECT_EQ(summary.status, LmStatus::kStoppedByCallback);
    EXPECT_EQ(recorder.rows.size(), 7U);
    EXPECT_EQ(ours.x == -1.2, answer == ceres::SOLVER_ABORT);
  }
}

// Computes a value that all residuals share, in Ceres's evaluation callback.
class Shared final : public ceres::EvaluationCallback {
 public:
  explicit Shared(const double* x) : x_(x) {}
  void PrepareForEvaluation(bool jacobians, bool is_new) override {
    jacobians_asked = jacobians_asked || jacobians;
    again = again || !is_new;
    if (is_new) square = *x_ * *x_;
  }
  double square = 0;
  bool jacobians_asked = false, again = false;

 private:
  const double* x_;
};
class SharedValley final : public ceres::SizedCostFunction<2, 1, 1> {
 public:
  explicit SharedValley(const Shared& shared) : shared_(shared) {}
  bool Evaluate(const double* const* p, double* r, double** jacobians) const override {
    r[0] = 10 * (p[1][0] - shared_.square);
    r[1] = 1 - p[0][0];
    if (jacobians == nullptr) return true;
    if (jacobians[0]) {
      jacobians[0][0] = -20 * p[0][0];
      jacobians[0][1] = -1;
    }
    if (jacobians[1]) {
      jacobians[1][0] = 10;
      jacobians[1][1] = 0;
    }
    return true;
  }

 private:
  const Shared& shared_;
};

TEST(CeresSolve, AnEvaluationCallbackSeesThePointInTheBlocks) {
  double x = -1.2, y = 1;
  Shared shared(&x);
  ceres::Problem problem;
  problem.AddResidualBlock(new SharedValley(shared), nullptr, &x, &y);
  const LmSummary summary = Solve(Quiet(), problem, {}, &shared);
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  EXPECT_NEAR(x, 1, 1e-6);
  EXPECT_NEAR(y, 1, 1e-6);
  EXPECT_TRUE(shared.jacobians_asked);
  EXPECT_TRUE(shared.again) << "the Jacobian is requested at the point of the cost";
}

// Only the headers of the solver are included here.
TEST(CeresSolve, TheHeadersBringTheError) {
  Rosenbrock ours;
  try {
    ceres_bridge::CeresProblem(ours.problem).block(nullptr);
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadArgument);
  }
}

TEST(CeresSolve, ListsWhatItIgnores) {
  EXPECT_TRUE(ceres_bridge::IgnoredOptions({}).empty());
  Rosenbrock ours;
  ceres::Solver::Options options = Quiet();
  options.trust_region_strategy_type = ceres::DOGLEG;
  options.use_inner_iterations = true;
  options.check_gradients = true;
  options.num_threads = 3;
  const LmSummary summary = Solve(options, ours.problem);
  EXPECT_EQ(summary.notes.size(), 4U);
  for (const char* name :
       {"trust_region_strategy_type = DOGLEG", "use_inner_iterations", "check_gradients", "num_threads"}) {
    EXPECT_TRUE(HasNote(summary, std::string(name) + " of ceres::Solver::Options is ignored")) << name;
  }
  options = {};
  options.minimizer_type = ceres::LINE_SEARCH;
  ASSERT_EQ(ceres_bridge::IgnoredOptions(options).size(), 1U);
  EXPECT_EQ(ceres_bridge::IgnoredOptions(options).front().find("minimizer_type = LINE_SEARCH"), 0U);
}

// Each residual block reads the common block and its own one, which is eliminated.
struct CommonAndOwn {
  double seen;
  template <class T>
  bool operator()(const T* common, const T* own, T* r) const {
    r[0] = common[0] + own[0] * own[0] - T(seen);
    r[1] = T(0.5) * own[0] - common[0];
    return true;
  }
};

TEST(CeresSolve, DirectSchurSolversFactorise) {
  for (const auto type : {ceres::DENSE_SCHUR, ceres::SPARSE_SCHUR}) {
    double common = 1;
    std::vector<double> own(20, 2.0);
    ceres::Problem problem;
    for (std::size_t i = 0; i < own.size(); ++i) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<CommonAndOwn, 2, 1, 1>(new CommonAndOwn{0.1 * static_cast<double>(i)}),
          nullptr, &common, &own[i]);
    }
    ceres::Solver::Options options = Quiet();
    options.linear_solver_type = type;
    const LmSummary summary = Solve(options, problem);
    EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
    EXPECT_EQ(summary.linear_solver.find("PCG on the Schur complement, sparse Cholesky of "), 0U)
        << summary.linear_solver;
    EXPECT_LE(summary.num_pcg_iterations, 2 * (summary.num_accepted + summary.num_rejected));
  }
}

}  // namespace
}  // namespace vesta
