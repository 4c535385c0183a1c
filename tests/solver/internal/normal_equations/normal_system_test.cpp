// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/normal_equations/normal_system.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "kernels/core/check.h"
#include "tests/solver/linear_problem.h"

namespace vesta {
namespace {

NormalSystemOptions Tight(PreconditionerKind kind = PreconditionerKind::kJacobi) {
  NormalSystemOptions options;
  options.linear_solver = LinearSolverKind::kPcg;
  options.preconditioner = kind;
  options.pcg = {.max_iterations = 200, .relative_tolerance = 1e-14, .model_tolerance = 0};
  return options;
}

class NormalSystemTest : public ::testing::Test {
 protected:
  ColumnScale<Cpu> ScaleOf(NormalSystem<Cpu>& system, ColumnScaling scaling = ColumnScaling::kInverseRoot) {
    return MakeColumnScale<Cpu>(scaling, backend_, system.diagonal());
  }
  Cpu backend_;
  PcgWorkspace<Cpu> workspace_;
};

TEST_F(NormalSystemTest, SolvesTheDampedSumOfBatches) {
  const auto first = RandomBatch(8, 5, 1), second = RandomBatch(6, 5, 2);
  LinearProblem problem({first, second});
  const Cpu::Vector x = Vector({1, 2, 3, 4, 5});
  const Eigen::MatrixXd h = test::Gram(first.a) + test::Gram(second.a);
  const Eigen::VectorXd g = test::ApplyTransposed(first.a, test::Apply(first.a, AsEigen(x.view())) - first.b) +
                            test::ApplyTransposed(second.a, test::Apply(second.a, AsEigen(x.view())) - second.b);
  const double lambda = 0.3;
  Eigen::MatrixXd damped = h;
  damped.diagonal() += lambda * h.diagonal();
  const Eigen::VectorXd expected = -test::SolveSymmetric(damped, g);

  problem.groups = {{5, 1, 0, 1, 5}};
  for (const auto kind :
       {PreconditionerKind::kIdentity, PreconditionerKind::kJacobi, PreconditionerKind::kBlockJacobi}) {
    NormalSystem<Cpu> system(backend_, problem, x, {0, 1});
    EXPECT_EQ(system.num_residuals(), 14);
    EXPECT_LE((AsEigen(system.rhs()) + g).norm(), 1e-13 * g.norm());
    EXPECT_LE((AsEigen(system.diagonal()) - h.diagonal()).norm(), 1e-14 * h.diagonal().norm());
    const auto scale = ScaleOf(system);
    auto options = Tight(kind);
    if (kind == PreconditionerKind::kIdentity) options.pcg.max_iterations = 5000;
    system.Prepare(options, x, scale);
    Cpu::Vector step(5);
    const auto solution = system.Solve(lambda, workspace_, step);
    EXPECT_EQ(solution.pcg.status, PcgStatus::kConverged) << ToString(kind);
    EXPECT_LE((AsEigen(step.view()) - expected).norm(), 1e-9 * expected.norm()) << ToString(kind);
    if (kind == PreconditionerKind::kBlockJacobi) {
      // The single block is the whole matrix, so the preconditioner is exact up to rounding.
      EXPECT_LE(solution.pcg.iterations, 3);
    }
  }
}

TEST_F(NormalSystemTest, ThePredictionIsExactEvenForAStepFarFromTheSolution) {
  const auto batch = RandomBatch(9, 5, 3);
  LinearProblem problem({batch});
  const Cpu::Vector x = Vector({1, -2, 3, -4, 5});
  const Eigen::MatrixXd h = test::Gram(batch.a);
  for (const auto scaling : {ColumnScaling::kNone, ColumnScaling::kInverseRoot, ColumnScaling::kOnePlusInverse}) {
    for (const int iterations : {1, 2, 3}) {
      NormalSystem<Cpu> system(backend_, problem, x, {0});
      const auto scale = ScaleOf(system, scaling);
      auto options = Tight();
      options.pcg.max_iterations = iterations;
      system.Prepare(options, x, scale);
      Cpu::Vector step(5), moved(5);
      const auto solution = system.Solve(0.7, workspace_, step);
      const double curvature = AsEigen(step.view()).dot(test::Apply(h, AsEigen(step.view())));
      EXPECT_NEAR(solution.curvature, curvature, 1e-11 * curvature);
      EXPECT_NEAR(system.Curvature(step), curvature, 1e-12 * curvature);
      // The problem is linear, so the model equals the cost.
      ProblemAdaptor<Cpu>(problem).Plus(backend_, x, step, moved);
      const double decrease = problem.Cost(x) - problem.Cost(moved);
      EXPECT_NEAR(-solution.gradient_dot_step - 0.5 * solution.curvature, decrease, 1e-11 * problem.Cost(x));
    }
  }
}

TEST_F(NormalSystemTest, AnOwnRightHandSideIsSolvedForAndThePredictionUsesTheGradient) {
  const auto first = RandomBatch(9, 5, 3), second = RandomBatch(6, 5, 8);
  const Cpu::Vector x = Vector({1, -2, 3, -4, 5});
  const Eigen::MatrixXd h = test::Gram(first.a) + test::Gram(second.a);
  const double lambda = 0.7;
  Eigen::MatrixXd damped = h;
  damped.diagonal() += lambda * h.diagonal();
  LinearProblem problem({first, second});
  problem.own_right_hand_side = Eigen::VectorXd{{1, 0.2, 0, 0.5, 0.9}};
  for (const int iterations : {1, 2, 200}) {
    NormalSystem<Cpu> system(backend_, problem, x, {0, 1});
    const auto scale = ScaleOf(system);
    auto options = Tight();
    options.pcg.max_iterations = iterations;
    system.Prepare(options, x, scale);
    Cpu::Vector step(5), moved(5);
    const auto solution = system.Solve(lambda, workspace_, step);
    const Eigen::VectorXd s = AsEigen(step.view()), g = -AsEigen(system.negative_gradient());
    const Eigen::VectorXd descent = -problem.own_right_hand_side.cwiseProduct(g);
    EXPECT_LE((AsEigen(system.rhs()) - descent).norm(), 1e-14 * descent.norm());
    if (iterations == 200) {
      const Eigen::VectorXd expected = test::SolveSymmetric(damped, descent);
      EXPECT_LE((s - expected).norm(), 1e-9 * expected.norm());
    }
    EXPECT_NEAR(solution.gradient_dot_step, g.dot(s), 1e-12 * std::abs(g.dot(s)));
    EXPECT_NEAR(solution.curvature, s.dot(test::Apply(h, s)), 1e-11 * s.dot(test::Apply(h, s)));
    ProblemAdaptor<Cpu>(problem).Plus(backend_, x, step, moved);
    const double decrease = problem.Cost(x) - problem.Cost(moved);
    EXPECT_NEAR(-solution.gradient_dot_step - 0.5 * solution.curvature, decrease, 1e-11 * problem.Cost(x));
  }
  // Solvers that use J and the residuals would solve for another right-hand side.
  for (const auto kind : {LinearSolverKind::kLsmr, LinearSolverKind::kDenseQr}) {
    NormalSystem<Cpu> system(backend_, problem, x, {0, 1});
    const auto scale = ScaleOf(system);
    auto options = Tight();
    options.linear_solver = kind;
    EXPECT_THROW(system.Prepare(options, x, scale), Error);
  }
}

TEST_F(NormalSystemTest, TheGradientAsRightHandSideIsTheDefaultToTheLastBit) {
  LinearProblem problem({RandomBatch(9, 5, 3), RandomBatch(6, 5, 8)});
  const Cpu::Vector x = Vector({1, -2, 3, -4, 5});
  std::vector<Cpu::Vector> steps;
  std::vector<StepSolution> solutions;
  for (const bool own : {false, true}) {
    problem.own_right_hand_side = Eigen::VectorXd::Ones(own ? 5 : 0);
    NormalSystem<Cpu> system(backend_, problem, x, {0, 1});
    EXPECT_EQ(system.rhs().data() != system.negative_gradient().data(), own) << "one vector if both are equal";
    const auto scale = ScaleOf(system);
    auto options = Tight();
    options.pcg.max_iterations = 3;
    system.Prepare(options, x, scale);
    solutions.push_back(system.Solve(0.7, workspace_, steps.emplace_back(5)));
  }
  EXPECT_EQ(AsEigen(steps[0].view()), AsEigen(steps[1].view()));
  EXPECT_EQ(solutions[0].gradient_dot_step, solutions[1].gradient_dot_step);
  EXPECT_EQ(solutions[0].curvature, solutions[1].curvature);
}

TEST_F(NormalSystemTest, BlocksAreMadeAgainForAnotherDamping) {
  const auto first = RandomBatch(9, 5, 31), second = RandomBatch(6, 5, 32);
  LinearProblem problem({first, second});
  problem.groups = {{5, 1, 0, 1, 5}};
  const Cpu::Vector x = Vector({1, 2, 3, 4, 5});
  NormalSystem<Cpu> system(backend_, problem, x, {0, 1});
  const auto scale = ScaleOf(system);
  system.Prepare(Tight(PreconditionerKind::kBlockJacobi), x, scale);
  const Eigen::MatrixXd h = test::Gram(first.a) + test::Gram(second.a);
  const Eigen::VectorXd descent = AsEigen(system.rhs());
  for (const double lambda : {0.3, 30.0, 30.0, 0.003}) {
    Eigen::MatrixXd damped = h;
    damped.diagonal() += lambda * h.diagonal();
    const Eigen::VectorXd expected = test::SolveSymmetric(damped, descent);
    Cpu::Vector step(5);
    const auto solution = system.Solve(lambda, workspace_, step);
    EXPECT_LE(solution.pcg.iterations, 3) << "one block is the whole matrix";
    EXPECT_LE((AsEigen(step.view()) - expected).norm(), 1e-12 * expected.norm()) << lambda;
  }
}

TEST_F(NormalSystemTest, TheDiagonalGoesUnlessTheSolverReadsIt) {
  LinearProblem problem({RandomBatch(9, 5, 33)});
  const Cpu::Vector x = Vector({1, 2, 3, 4, 5});
  for (const auto kind : {LinearSolverKind::kPcg, LinearSolverKind::kLsmr, LinearSolverKind::kDenseQr}) {
    auto options = Tight();
    options.linear_solver = kind;
    std::vector<Cpu::Vector> steps;
    for (const bool keep : {true, false}) {
      NormalSystem<Cpu> system(backend_, problem, x, {0});
      const auto scale = ScaleOf(system);
      system.Prepare(options, x, scale, keep);
      EXPECT_EQ(system.diagonal().size(), keep || kind == LinearSolverKind::kLsmr ? 5 : 0);
      system.Solve(0.5, workspace_, steps.emplace_back(5));
    }
    EXPECT_EQ(AsEigen(steps[0].view()), AsEigen(steps[1].view()));
  }
}

TEST_F(NormalSystemTest, ZeroColumnsStay) {
  auto batch = RandomBatch(9, 5, 4);
  batch.a.col(2).setZero();
  LinearProblem problem({batch});
  const Cpu::Vector x(5);
  problem.groups = {{5, 1, 0, 1, 5}};
  for (const auto kind :
       {PreconditionerKind::kIdentity, PreconditionerKind::kJacobi, PreconditionerKind::kBlockJacobi}) {
    NormalSystem<Cpu> system(backend_, problem, x, {0});
    const auto scale = ScaleOf(system);
    system.Prepare(Tight(kind), x, scale);
    EXPECT_EQ(system.num_zero_columns(), 1);
    EXPECT_EQ(scale.square[2], 1);
    Cpu::Vector step(5);
    system.Solve(1e-3, workspace_, step);
    EXPECT_EQ(step[2], 0);
    EXPECT_GT(std::abs(step[1]), 0);
    EXPECT_TRUE(backend_.AllFinite(step));
  }
}

TEST_F(NormalSystemTest, TheProblemsMetricReplacesTheDiagonal) {
  const auto batch = RandomBatch(9, 4, 5);
  LinearProblem problem({batch});
  problem.own_metric = 2.5;
  const Cpu::Vector x = Vector({1, 1, 1, 1});
  NormalSystem<Cpu> system(backend_, problem, x, {0});
  const auto scale = ScaleOf(system);
  system.Prepare(Tight(), x, scale);
  Cpu::Vector step(4);
  system.Solve(0.2, workspace_, step);
  const Eigen::MatrixXd h = test::Gram(batch.a);
  const Eigen::VectorXd g = test::ApplyTransposed(batch.a, test::Apply(batch.a, AsEigen(x.view())) - batch.b);
  const Eigen::VectorXd expected = -test::SolveSymmetric(h + 0.5 * Eigen::MatrixXd::Identity(4, 4), g);
  EXPECT_LE((AsEigen(step.view()) - expected).norm(), 1e-10 * expected.norm());
  EXPECT_LE((problem.last_diag_h - h.diagonal()).norm(), 1e-13 * h.norm());
}

TEST_F(NormalSystemTest, APreconditionerOfAnotherDampingFindsTheSameStep) {
  LinearProblem problem({RandomBatch(9, 4, 6)});
  const Cpu::Vector x = Vector({1, 1, 1, 1});
  std::vector<Cpu::Vector> steps;
  std::vector<double> residuals;
  for (const std::optional<double> lambda : {std::optional<double>(), std::optional(0.0), std::optional(1.0)}) {
    NormalSystem<Cpu> system(backend_, problem, x, {0});
    const auto scale = ScaleOf(system, ColumnScaling::kNone);
    auto options = Tight();
    options.preconditioner_lambda = lambda;
    options.metric.min_diagonal = 1;  // so that the two metrics differ by more than a factor
    system.Prepare(options, x, scale);
    system.Solve(0.5, workspace_, steps.emplace_back(4));
    // The iterates differ: compare the residuals after one iteration.
    options.pcg.max_iterations = 1;
    NormalSystem<Cpu> short_system(backend_, problem, x, {0});
    short_system.Prepare(options, x, scale);
    Cpu::Vector first(4);
    residuals.push_back(short_system.Solve(0.5, workspace_, first).pcg.residual_norm);
  }
  for (const std::size_t k : {1u, 2u}) {
    const auto difference = AsEigen(steps[0].view()) - AsEigen(steps[k].view());
    EXPECT_LE(difference.norm(), 1e-11 * AsEigen(steps[0].view()).norm());
    EXPECT_NE(residuals[0], residuals[k]);
  }
}

TEST_F(NormalSystemTest, ScalesAndClamps) {
  const Cpu::Vector d = Vector({0, 4, 9, 1e-20});
  const auto root = MakeColumnScale<Cpu>(ColumnScaling::kInverseRoot, backend_, d);
  EXPECT_EQ(root.inverse_square[0], 1);
  EXPECT_EQ(root.inverse_square[1], 4);
  EXPECT_EQ(root.square[2], 1.0 / 9);
  const auto ceres = MakeColumnScale<Cpu>(ColumnScaling::kOnePlusInverse, backend_, d);
  EXPECT_EQ(ceres.inverse_square[0], 1);
  EXPECT_EQ(ceres.inverse_square[2], 16);
  // Later the columns have other norms; the damping depends on them in the units of the start.
  const Cpu::Vector later = Vector({1e-9, 4, 9e-9, 1});
  Cpu::Vector metric(4);
  DiagonalMetric<Cpu>({}, backend_, later, root, {}, metric);
  EXPECT_DOUBLE_EQ(metric[0], 1e-6);
  EXPECT_DOUBLE_EQ(metric[1], 4);
  EXPECT_DOUBLE_EQ(metric[2], 9e-6);
  EXPECT_DOUBLE_EQ(metric[3], 1);
}

TEST_F(NormalSystemTest, TheFloorFollowsTheGroupsMedian) {
  // Two groups of single entries: the medians of the positive values are 100 and 1.
  const Cpu::Vector d = Vector({1e-3, 100, 1e5, 0, 1, 2, 1e-4});
  const auto scale = MakeColumnScale<Cpu>(ColumnScaling::kNone, backend_, d);
  Cpu::Vector metric(7);
  DampingMetricOptions options;
  options.min_diagonal = 1e-12;
  options.group_median_floor = 1e-2;
  DiagonalMetric<Cpu>(options, backend_, d, scale, {{1, 4, 0, 4, 1}, {1, 3, 4, 3, 1}}, metric);
  const double expected[] = {1, 100, 1e5, 1, 1, 2, 1e-2};
  for (Index k = 0; k < 7; ++k) EXPECT_DOUBLE_EQ(metric[k], expected[k]) << k;
}

}  // namespace
}  // namespace vesta
