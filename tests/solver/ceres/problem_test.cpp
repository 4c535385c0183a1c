// SPDX-License-Identifier: Apache-2.0
// Building, querying and evaluating problems. Adapted from Ceres 2.1's test internal/ceres/problem_test.cc;
// docs/ceres_tests.md lists the omitted cases. ceres::Problem::Evaluate computes the expected values.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "solver/ceres/ceres_problem.h"
#include "solver/evaluate.h"
#include "tests/solver/ceres/twin_problem.h"
#include "tests/solver/dense_operator.h"
#include "tests/support/linearize_at.h"
#include "tests/support/throws_error.h"

namespace vesta::test {
namespace {

using ceres_bridge::CeresProblem;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The cost, residuals, gradient and Jacobian of a problem. The columns belong to `blocks`, one block after another.
struct Evaluated {
  double cost = 0;
  Eigen::VectorXd residuals, gradient;
  Eigen::MatrixXd jacobian;
};

Evaluated EvaluateTheirs(ceres::Problem& problem, const ceres::Problem::EvaluateOptions& options) {
  std::vector<double> residuals, gradient;
  ceres::CRSMatrix jacobian;
  Evaluated result;
  EXPECT_TRUE(problem.Evaluate(options, &result.cost, &residuals, &gradient, &jacobian));
  result.residuals = Eigen::VectorXd::Map(residuals.data(), static_cast<Eigen::Index>(residuals.size()));
  result.gradient = Eigen::VectorXd::Map(gradient.data(), static_cast<Eigen::Index>(gradient.size()));
  result.jacobian = Eigen::MatrixXd::Zero(jacobian.num_rows, jacobian.num_cols);
  for (int row = 0; row < jacobian.num_rows; ++row) {
    for (int k = jacobian.rows[row]; k < jacobian.rows[row + 1]; ++k) {
      result.jacobian(row, jacobian.cols[k]) += jacobian.values[k];
    }
  }
  return result;
}

Evaluated EvaluateTheirs(ceres::Problem& problem, std::vector<double*> blocks) {
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = std::move(blocks);
  return EvaluateTheirs(problem, options);
}

// By Evaluate.
Evaluated EvaluateOurs(BlockProblem& problem, Cpu::ConstVectorView x, const EvaluateOptions& options) {
  const BlockEvaluation from = Evaluate(problem, x, options);
  Evaluated result{from.cost, Eigen::VectorXd::Map(from.residuals.data(), std::ssize(from.residuals)),
                   Eigen::VectorXd::Map(from.gradient.data(), std::ssize(from.gradient)),
                   Eigen::MatrixXd::Zero(from.jacobian.rows, from.jacobian.cols)};
  for (Index row = 0; row < from.jacobian.rows; ++row) {
    const auto at = static_cast<std::size_t>(row);
    Index last = -1;
    for (auto k = static_cast<std::size_t>(from.jacobian.row_starts[at]);
         k < static_cast<std::size_t>(from.jacobian.row_starts[at + 1]); ++k) {
      EXPECT_GT(from.jacobian.columns[k], last);
      last = from.jacobian.columns[k];
      result.jacobian(row, last) = from.jacobian.values[k];
    }
  }
  return result;
}

// By the linearization, which a solve uses.
Evaluated EvaluateOurs(BlockProblem& problem, Cpu::ConstVectorView x, const std::vector<int>& blocks) {
  const auto linearization = LinearizeAt<Cpu>(problem, x);
  const Index rows = linearization->num_residuals();
  Cpu::Vector direction(problem.num_tangent()), column(rows), slope(problem.num_tangent());
  linearization->ApplyJT(linearization->residuals(), slope);
  Index columns = 0;
  for (const int block : blocks) columns += problem.tangent_size(block);
  Evaluated result{problem.Cost(x), AsEigen(linearization->residuals()), Eigen::VectorXd(columns),
                   Eigen::MatrixXd(rows, columns)};
  Index c = 0;
  for (const int block : blocks) {
    for (int k = 0; k < problem.tangent_size(block); ++k, ++c) {
      const Index at = problem.tangent_offset(block) + k;
      direction[at] = 1;
      linearization->ApplyJ(direction, column);
      direction[at] = 0;
      result.jacobian.col(c) = AsEigen(column.view());
      result.gradient[c] = slope[at];
    }
  }
  return result;
}

void ExpectSameEvaluation(const Evaluated& ours, const Evaluated& theirs) {
  EXPECT_NEAR(ours.cost, theirs.cost, 1e-14 * theirs.cost);
  ASSERT_EQ(ours.residuals.size(), theirs.residuals.size());
  EXPECT_LE((ours.residuals - theirs.residuals).norm(), 1e-14 * theirs.residuals.norm());
  ASSERT_EQ(ours.gradient.size(), theirs.gradient.size());
  EXPECT_LE((ours.gradient - theirs.gradient).norm(), 1e-14 * theirs.gradient.norm());
  ASSERT_EQ(ours.jacobian.cols(), theirs.jacobian.cols());
  EXPECT_LE((ours.jacobian - theirs.jacobian).norm(), 1e-14 * theirs.jacobian.norm());
}

// Compares the columns of these blocks, natively and through the bridge.
void ExpectSameEvaluation(TwinProblem& twin, const std::vector<int>& blocks) {
  std::vector<double*> theirs;
  theirs.reserve(blocks.size());
  for (const int block : blocks) theirs.push_back(twin.values(block));
  const Evaluated expected = EvaluateTheirs(twin.theirs(), theirs);
  const std::vector<double> x = twin.x();
  ExpectSameEvaluation(EvaluateOurs(twin.ours(), View(x), blocks), expected);
  ExpectSameEvaluation(EvaluateOurs(twin.ours(), View(x), EvaluateOptions{.parameter_blocks = blocks}), expected);
  CeresProblem bridge(twin.theirs());
  std::vector<int> bridged;
  bridged.reserve(blocks.size());
  for (const double* block : theirs) bridged.push_back(bridge.block(block));
  ExpectSameEvaluation(EvaluateOurs(bridge.problem(), bridge.Gather(), bridged), expected);
}

TwinManifold Subset(int size, const std::vector<int>& constant) {
  return {std::make_shared<ceres::SubsetManifold>(size, constant), std::make_shared<SubsetManifold>(size, constant)};
}

// Three blocks x, y, z with the values 1, ..., 6, and residuals i - p_i^2 - 2 q_i^2, i = 0 or 1, of the pairs (p, q) =
// (x, y), (y, z), (z, x).
struct Circle : TwinProblem {
  Circle() {
    for (const double value : {1.0, 3.0, 5.0}) AddBlock({value, value + 1});
    for (const auto& [first, second] : {std::pair(0, 1), std::pair(1, 2), std::pair(2, 0)}) {
      Add(2,
          [](const double* const* p, double* r, double** j) {
            for (int i = 0; i < 2; ++i) {
              r[i] = i;
              for (int b = 0; b < 2; ++b) {
                r[i] -= (b + 1) * p[b][i] * p[b][i];
                if (j == nullptr || j[b] == nullptr) continue;
                for (int k = 0; k < 2; ++k) j[b][2 * i + k] = k == i ? -2 * (b + 1) * p[b][i] : 0;
              }
            }
            return true;
          },
          {first, second});
    }
  }
};

TEST(CeresCasesProblem, EvaluatesBlocksInAnyOrder) {
  Circle circle;
  ExpectSameEvaluation(circle, {0, 1, 2});
  ExpectSameEvaluation(circle, {2, 1, 0});
  const std::vector<double> x = circle.x();
  EXPECT_EQ(circle.ours().Cost(View(x)), 7607);
}

TEST(CeresCasesProblem, EvaluatesWithoutSomeBlocks) {
  Circle circle;
  ExpectSameEvaluation(circle, {0, 2});
  // A subset of the residual blocks.
  const std::vector<double> x = circle.x();
  std::vector<ceres::ResidualBlockId> all;
  circle.theirs().GetResidualBlocks(&all);
  for (const std::vector<Index>& chosen : {std::vector<Index>{0, 2}, {1, 0}, {2, 1, 0}}) {
    ceres::Problem::EvaluateOptions theirs;
    for (const Index id : chosen) theirs.residual_blocks.push_back(all[static_cast<std::size_t>(id)]);
    for (const int block : {1, 0}) theirs.parameter_blocks.push_back(circle.values(block));
    const EvaluateOptions ours{.residual_blocks = chosen, .parameter_blocks = std::vector<int>{1, 0}};
    ExpectSameEvaluation(EvaluateOurs(circle.ours(), View(x), ours), EvaluateTheirs(circle.theirs(), theirs));
  }
  const auto at = View(x);
  const Index f_h[] = {0, 2}, f_g[] = {0, 1};
  EXPECT_EQ(circle.ours().Cost(at, f_h), 2082);
  EXPECT_EQ(circle.ours().Cost(at, f_g), 6318);
}

TEST(CeresCasesProblem, EvaluatesWithAConstantBlock) {
  Circle circle;
  circle.SetConstant(1);
  ExpectSameEvaluation(circle, {0, 2});
  const std::vector<double> x = circle.x();
  ExpectSameEvaluation(EvaluateOurs(circle.ours(), View(x), EvaluateOptions()),
                       EvaluateTheirs(circle.theirs(), ceres::Problem::EvaluateOptions()));
  EXPECT_EQ(circle.ours().tangent_size(1), 0);
}

TEST(CeresCasesProblem, EvaluatesOnAManifold) {
  Circle circle;
  circle.SetManifold(1, Subset(2, {0}));
  ExpectSameEvaluation(circle, {0, 1, 2});
  EXPECT_EQ(circle.ours().num_tangent(), 5);
}

// One residual block whose five residuals are its blocks x = (1, 2) and y = (1, 2, 3).
struct Identity : TwinProblem {
  explicit Identity(const TwinLoss& loss = {}) {
    AddBlock({1, 2});
    AddBlock({1, 2, 3});
    Add<5, 2, 3>(Copy(), {0, 1}, loss);
  }
  struct Copy {
    template <class T>
    bool operator()(const T* x, const T* y, T* r) const {
      for (int i = 0; i < 2; ++i) r[i] = x[i];
      for (int i = 0; i < 3; ++i) r[2 + i] = y[i];
      return true;
    }
  };
};

TEST(CeresCasesProblem, EvaluatesAResidualBlock) {
  Identity plain;
  ExpectSameEvaluation(plain, {0, 1});
  ExpectSameEvaluation(plain, {0});
  // Residuals alone, and one Jacobian.
  const AutoDiffCost<Identity::Copy, 5, 2, 3> cost;
  const double* const parameters[] = {plain.values(0), plain.values(1)};
  double residuals[5] = {}, by_x[10] = {};
  double* jacobians[] = {by_x, nullptr};
  ASSERT_TRUE(cost.Evaluate(parameters, residuals, nullptr));
  EXPECT_EQ(residuals[4], 3);
  ASSERT_TRUE(cost.Evaluate(parameters, residuals, jacobians));
  EXPECT_EQ(residuals[4], 3);
  for (int k = 0; k < 10; ++k) EXPECT_EQ(by_x[k], k == 0 || k == 3);
}

TEST(CeresCasesProblem, EvaluatesAResidualBlockWithALoss) {
  Identity twin({std::make_shared<ceres::ScaledLoss>(nullptr, 2.0, ceres::TAKE_OWNERSHIP),
                 std::make_shared<ScaledLoss>(nullptr, 2.0)});
  ExpectSameEvaluation(twin, {0, 1});
  const std::vector<double> x = twin.x();
  EXPECT_EQ(twin.ours().Cost(View(x)), 19);
  ceres::Problem::EvaluateOptions without;
  without.apply_loss_function = false;
  ExpectSameEvaluation(EvaluateOurs(twin.ours(), View(x), EvaluateOptions{.apply_loss = false}),
                       EvaluateTheirs(twin.theirs(), without));
}

TEST(CeresCasesProblem, EvaluatesWithACurvedLoss) {
  Identity twin({std::make_shared<ceres::CauchyLoss>(0.5), std::make_shared<CauchyLoss>(0.5)});
  ExpectSameEvaluation(twin, {1, 0});
  ExpectSameEvaluation(twin, {0});
}

TEST(CeresCasesProblem, EvaluatesAResidualBlockOnManifolds) {
  Identity twin;
  twin.SetManifold(0, Subset(2, {1}));
  ExpectSameEvaluation(twin, {0, 1});
  twin.SetManifold(1, Subset(3, {2}));
  ExpectSameEvaluation(twin, {0, 1});
  EXPECT_EQ(twin.ours().num_tangent(), 3);
}

TEST(CeresCasesProblem, EvaluatesAResidualBlockOfConstants) {
  Identity twin;
  twin.SetConstant(0);
  ExpectSameEvaluation(twin, {1});
  twin.values(0)[0] = 2;
  twin.values(1)[2] = 1;
  ExpectSameEvaluation(twin, {1});
  twin.SetConstant(1);
  const std::vector<double> x = twin.x();
  const auto at = View(x);
  EXPECT_EQ(twin.ours().Cost(at), 7);
  EXPECT_EQ(twin.ours().FixedCost(at), 7);
  EXPECT_EQ(twin.ours().Linearize(at)->num_residuals(), 0);
}

TEST(CeresCasesProblem, BlocksBecomeConstantAndVariable) {
  Circle circle;
  BlockProblem& problem = circle.ours();
  const auto expect_sizes = [&](int x, int y) {
    EXPECT_EQ(problem.tangent_size(0), x);
    EXPECT_EQ(problem.tangent_size(1), y);
  };
  expect_sizes(2, 2);
  problem.SetConstant(0);
  expect_sizes(0, 2);
  problem.SetConstant(1);
  expect_sizes(0, 0);
  problem.SetConstant(0, false);
  expect_sizes(2, 0);
}

TEST(CeresCasesProblem, AManifoldMayBeReplacedAndRemoved) {
  Identity twin;
  BlockProblem& problem = twin.ours();
  twin.SetManifold(1, Subset(3, {1}));
  EXPECT_EQ(problem.tangent_size(1), 2);
  twin.SetManifold(1, Subset(3, {0, 1}));
  EXPECT_EQ(problem.tangent_size(1), 1);
  ExpectSameEvaluation(twin, {0, 1});
  twin.SetManifold(1, {});
  EXPECT_EQ(problem.tangent_size(1), 3);
  EXPECT_EQ(problem.parameter_block_size(1), 3);
  ExpectSameEvaluation(twin, {0, 1});
}

// A manifold of Ceres may have the tangent size 0, which makes the block constant. vesta refuses such a manifold.
TEST(CeresCasesProblem, AManifoldWithoutTangentMakesTheBlockConstant) {
  Circle circle;
  ceres::SubsetManifold all(2, {0, 1});
  circle.theirs().SetManifold(circle.values(1), &all);
  ASSERT_TRUE(circle.theirs().IsParameterBlockConstant(circle.values(1)));
  CeresProblem bridge(circle.theirs());
  EXPECT_EQ(bridge.problem().tangent_size(bridge.block(circle.values(1))), 0);
  EXPECT_EQ(bridge.problem().num_tangent(), 4);
  EXPECT_THAT([] { SubsetManifold(2, {0, 1}); }, ThrowsError(kBadArgument));
}

TEST(CeresCasesProblem, BoundsMayBeReplacedAndRemoved) {
  TwinProblem twin;
  const int block = twin.AddBlock({1, 2});
  twin.Add(1, [](const double* const* p, double* r, double**) { return r[0] = p[0][0], true; }, {block});
  BlockProblem& problem = twin.ours();
  const auto feasible = [&](double first, double second) {
    const std::vector<double> x = {first, second};
    CeresProblem bridge(twin.theirs());
    const bool native = problem.IsFeasible(View(x));
    EXPECT_EQ(native, bridge.problem().IsFeasible(View(x)));
    return native;
  };
  EXPECT_TRUE(feasible(-1e300, 1e300));
  for (const double bound : {1.0, 2.0}) {
    twin.SetBounds(0, 0, -bound, bound);
    EXPECT_TRUE(feasible(bound, 1e300));
    EXPECT_FALSE(feasible(-bound - 0.5, 0));
    EXPECT_FALSE(feasible(bound + 0.5, 0));
  }
  twin.ours().SetBounds(0, 0, -kInfinity, kInfinity);
  twin.theirs().SetParameterLowerBound(twin.values(0), 0, -std::numeric_limits<double>::max());
  twin.theirs().SetParameterUpperBound(twin.values(0), 0, std::numeric_limits<double>::max());
  EXPECT_TRUE(feasible(-3, 3));
}

TEST(CeresCasesProblem, MisuseIsRefused) {
  Identity twin;
  BlockProblem& problem = twin.ours();
  const auto cost = std::make_shared<AutoDiffCost<Identity::Copy, 5, 2, 3>>();
  const int other = problem.AddParameterBlock(4);
  // Too few blocks, sizes of other blocks, one block twice.
  EXPECT_THAT([&] { problem.AddResidualBlock(cost, nullptr, {0}); }, ThrowsError(kBadArgument));
  EXPECT_THAT([&] { problem.AddResidualBlock(cost, nullptr, {0, other}); }, ThrowsError(kBadArgument));
  EXPECT_THAT([&] { problem.AddResidualBlock(cost, nullptr, {1, 0}); }, ThrowsError(kBadArgument));
  EXPECT_THAT([&] { problem.AddResidualBlock(cost, nullptr, {0, 1, 1}); }, ThrowsError(kBadArgument));
  // Unknown blocks.
  EXPECT_THAT([&] { problem.SetConstant(3); }, ThrowsError(kBadArgument));
  EXPECT_THAT([&] { problem.SetConstant(-1, false); }, ThrowsError(kBadArgument));
  EXPECT_THAT([&] { problem.SetManifold(3, nullptr); }, ThrowsError(kBadArgument));
  EXPECT_THAT([&] { problem.SetBounds(3, 0, 0, 1); }, ThrowsError(kBadArgument));
  EXPECT_THAT([&] { problem.SetBounds(0, 2, 0, 1); }, ThrowsError(kBadArgument));
  EXPECT_THAT([&] { problem.tangent_size(3); }, ThrowsError(kBadArgument));
  CeresProblem bridge(twin.theirs());
  const double unknown = 0;
  EXPECT_THAT([&] { bridge.block(&unknown); }, ThrowsError(kBadArgument));
  EXPECT_EQ(bridge.problem().parameter_block_size(bridge.block(twin.values(1))), 3);
}

}  // namespace
}  // namespace vesta::test
