// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/batched_system.h"

#include <gtest/gtest.h>

#include <cmath>

#include "problems/toy/toy_problems.h"
#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"
#include "tests/solver/linear_problem.h"

namespace vesta {
namespace {

using Fit = ResidualBlocks<ExponentialFit, Cpu>;

LmOptions Options(BatchMode mode) {
  LmOptions options;
  options.batch_mode = mode;
  options.max_iterations = 100;
  options.function_tolerance = 1e-14;
  options.normal_system.pcg = {.max_iterations = 20, .relative_tolerance = 1e-12, .model_tolerance = 0};
  return options;
}

double FinalCost(const LmOptions& options, ResidualBlocksOptions blocks) {
  Fit problem(2, ExponentialSamples(200), {}, std::move(blocks));
  Cpu backend;
  Cpu::Vector x = Vector({0, 0});
  return SolveLm(options, backend, problem, x.view()).final_cost;
}

TEST(BatchedSystem, TheExactSumIsTheWholeProblem) {
  const double whole = FinalCost(Options(BatchMode::kExact), {});
  for (const BatchSplit split : {BatchSplit::kStrided, BatchSplit::kContiguous}) {
    EXPECT_NEAR(FinalCost(Options(BatchMode::kExact), {.num_batches = 4, .split = split}), whole, 1e-10 * whole);
  }
}

TEST(BatchedSystem, StridedBatchesReachTheMinimumWhereContiguousOnesAreBiased) {
  const double whole = FinalCost(Options(BatchMode::kExact), {});
  const double strided = FinalCost(Options(BatchMode::kMerge), {.num_batches = 4, .split = BatchSplit::kStrided});
  const double contiguous = FinalCost(Options(BatchMode::kMerge), {.num_batches = 4, .split = BatchSplit::kContiguous});
  EXPECT_LE(std::abs(strided - whole), 1e-4 * whole);
  EXPECT_GT(contiguous, 1.001 * whole);
}

TEST(BatchedSystem, OneBatchMergedIsItself) {
  EXPECT_EQ(FinalCost(Options(BatchMode::kMerge), {}), FinalCost(Options(BatchMode::kExact), {}));
}

TEST(BatchedSystem, MergesByTheDiagonalsAndPredictsOverAllBatches) {
  auto first = RandomBatch(6, 4, 11), second = RandomBatch(7, 4, 12);
  first.a.col(1).setZero();  // non-zero in one batch only
  first.a.col(2).setZero();  // zero in both batches
  second.a.col(2).setZero();
  LinearProblem problem({first, second});
  const Cpu::Vector x = Vector({1, -1, 2, 0.5});
  const double lambda = 0.1;
  problem.own_right_hand_side = Eigen::VectorXd{{0.5, 1, 1, 0.1}};
  Eigen::VectorXd numerator = Eigen::VectorXd::Zero(4), weight = Eigen::VectorXd::Zero(4);
  for (const auto& batch : {first, second}) {
    const Eigen::MatrixXd h = test::Gram(batch.a);
    Eigen::MatrixXd damped = h;
    damped.diagonal() += lambda * h.diagonal();
    for (int k = 0; k < 4; ++k) damped(k, k) = std::max(damped(k, k), 1e-12);
    const Eigen::VectorXd step =
        -test::SolveSymmetric(damped, problem.own_right_hand_side.cwiseProduct(test::ApplyTransposed(
                                          batch.a, test::Apply(batch.a, AsEigen(x.view())) - batch.b)));
    numerator += h.diagonal().cwiseProduct(step);
    weight += h.diagonal();
  }
  for (const bool hold : {true, false}) {
    LmOptions options = Options(BatchMode::kMerge);
    options.hold_batches = hold;
    // The clamp must not affect the small columns of one batch.
    options.normal_system.metric.min_diagonal = 1e-30;
    Cpu backend;
    ColumnScale<Cpu> scale;
    LmSummary summary;
    PcgWorkspace<Cpu> workspace;
    Cpu::Vector step(4), moved(4);
    BatchedSystem<Cpu> batched(options, backend, problem, x.view(), problem.Cost(x), scale, summary);
    const auto direction = batched.Solve(lambda, workspace, step);
    EXPECT_EQ(summary.num_zero_columns, 1);
    for (int k = 0; k < 4; ++k) {
      const double expected = weight(k) > 0 ? numerator(k) / weight(k) : 0;
      EXPECT_NEAR(step[k], expected, 1e-8 * std::abs(expected)) << k;
    }
    for (const double gamma : {1.0, 0.3}) {
      backend.Axpby(gamma, step, 0, moved);
      backend.Axpby(1, x, 1, moved);
      EXPECT_NEAR(direction.Predicted(gamma), problem.Cost(x) - problem.Cost(moved), 1e-10 * problem.Cost(x));
    }
  }
}

TEST(BatchedSystem, NotHoldingBatchesChangesNothingButTheWork) {
  LmOptions options = Options(BatchMode::kMerge);
  const ResidualBlocksOptions blocks{.num_batches = 4};
  const double held = FinalCost(options, blocks);
  options.hold_batches = false;
  EXPECT_EQ(FinalCost(options, blocks), held);
}

}  // namespace
}  // namespace vesta
