// SPDX-License-Identifier: Apache-2.0
#include "problems/program/batch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "kernels/core/error.h"
#include "solver/evaluate.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::program {
namespace {

// a exp(-b t) - y, with the blocks {a} and {b, unused}.
Program Decay() {
  using enum Operation;
  ProgramBuilder builder(5);
  const int a = builder.Input(0), b = builder.Input(1), t = builder.Input(3), y = builder.Input(4);
  const int model = builder.Add(kMultiply, a, builder.Add(kExp, builder.Add(kNegate, builder.Add(kMultiply, b, t))));
  return builder.Finish({builder.Add(kSubtract, model, y)});
}

struct DecayFunctor {
  double t, y;
  template <class T>
  void operator()(const T* a, const T* b, T* r) const {
    using std::exp;
    r[0] = a[0] * exp(-(b[0] * t)) - y;
  }
};

// More rows than a chunk, and a last chunk that is not full.
constexpr int kRows = 150;

struct Data {
  std::vector<double> values = std::vector<double>(2 * kRows);  // t, then y
  Data() {
    for (int i = 0; i < kRows; ++i) {
      const auto k = static_cast<std::size_t>(i);
      values[k] = 0.02 * i;
      values[kRows + k] = 2.5 * std::exp(-1.3 * values[k]) + 0.01 * std::sin(7.0 * i);
    }
  }
};

std::vector<int> RepeatedBlocks() {
  std::vector<int> blocks;
  for (int i = 0; i < kRows; ++i) blocks.insert(blocks.end(), {0, 1});
  return blocks;
}

TEST(BatchTest, EqualsResidualBlocksOfAFunctor) {
  const Data data;
  BatchProblem batch;
  BlockProblem reference;
  for (BlockProblem* problem : {&batch.blocks(), &reference}) {
    const double a = 1, b[] = {1, 3};
    problem->Set(problem->AddParameterBlock(1), &a);
    problem->Set(problem->AddParameterBlock(2), b);
  }
  const std::vector<int> blocks = RepeatedBlocks();
  batch.Add(std::make_shared<ProgramBatch>(batch.blocks(), Decay(), std::vector<int>{1, 2}, blocks, data.values), kRows,
            1, {1, 2}, blocks, std::make_shared<HuberLoss>(0.01));
  for (int i = 0; i < kRows; ++i) {
    const auto k = static_cast<std::size_t>(i);
    reference.AddResidualBlock(
        std::make_shared<AutoDiffCost<DecayFunctor, 1, 1, 2>>(DecayFunctor{data.values[k], data.values[kRows + k]}),
        std::make_shared<HuberLoss>(0.01), {0, 1});
  }
  const BlockEvaluation ours = Evaluate(batch.blocks(), batch.blocks().Gather().view());
  const BlockEvaluation theirs = Evaluate(reference, reference.Gather().view());
  ASSERT_EQ(ours.jacobian.values.size(), theirs.jacobian.values.size());
  for (std::size_t i = 0; i < theirs.jacobian.values.size(); ++i) {
    EXPECT_NEAR(ours.jacobian.values[i], theirs.jacobian.values[i], 1e-14);
  }
  for (std::size_t i = 0; i < kRows; ++i) EXPECT_NEAR(ours.residuals[i], theirs.residuals[i], 1e-15);
  EXPECT_NEAR(ours.cost, theirs.cost, 1e-14 * theirs.cost);

  const LmSummary summary = SolveLm(batch.blocks());
  SolveLm(reference);
  EXPECT_TRUE(IsConverged(summary.status)) << summary.message;
  EXPECT_NEAR(batch.blocks().Get(0)[0], reference.Get(0)[0], 1e-9);
  EXPECT_NEAR(batch.blocks().Get(1)[0], reference.Get(1)[0], 1e-9);
  EXPECT_EQ(batch.blocks().Get(1)[1], 3) << "the entry that the program does not read";
}

TEST(BatchTest, RefusesWhatDoesNotFit) {
  const Data data;
  BatchProblem problem;
  problem.blocks().AddParameterBlock(1);
  problem.blocks().AddParameterBlock(2);
  const std::vector<int> blocks = RepeatedBlocks();
  const auto make = [&](const std::vector<int>& sizes, std::span<const int> of, std::span<const double> values) {
    return std::make_shared<ProgramBatch>(problem.blocks(), Decay(), sizes, of, values);
  };
  EXPECT_THROW(make({1, 1}, blocks, data.values), Error) << "three data";
  EXPECT_THROW(make({2, 1}, blocks, data.values), Error) << "sizes in the wrong order";
  EXPECT_THROW(make({1, 2}, blocks, std::span(data.values).first(7)), Error);
  EXPECT_THROW(make({1, 2}, std::span(blocks).first(7), data.values), Error);
  const auto batch = make({1, 2}, blocks, data.values);
  EXPECT_THROW(problem.Add(batch, kRows + 1, 1, {1, 2}, blocks), Error);
}

}  // namespace
}  // namespace vesta::program
