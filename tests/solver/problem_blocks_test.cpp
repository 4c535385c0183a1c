// SPDX-License-Identifier: Apache-2.0
// Blocks of a BlockProblem that are added and removed between solves, and the values that the problem keeps.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "solver/block_problem.h"
#include "solver/evaluate.h"
#include "solver/levenberg_marquardt.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

using Cpu = CpuBackend<double>;

// p - q - value, for blocks of two numbers.
struct Between {
  double value;
  template <class T>
  void operator()(const T* p, const T* q, T* r) const {
    for (int i = 0; i < 2; ++i) r[i] = p[i] - q[i] - T(value + i);
  }
};
// The same, with the numbers of both blocks behind one pointer, as ResidualBlocks passes them.
struct BetweenJoined {
  static constexpr int kResiduals = 2, kParameters = 4;
  double value;
  template <class T>
  void operator()(const T* p, T* r) const {
    Between{value}(p, p + 2, r);
  }
};
using BetweenCost = AutoDiffCost<Between, 2, 2, 2>;
using JoinedCost = AutoDiffCost<BetweenJoined, 2, 2, 2>;

std::shared_ptr<const CostFunction> Anchor(double value) {
  return std::make_shared<NormalPrior>(std::vector<double>{1, 0, 0, 1}, std::vector<double>{value, value});
}

// A chain of blocks: the first is at `start`, and each next one is by (1, 2) below.
struct Chain {
  explicit Chain(int length) {
    for (int k = 0; k < length; ++k) Append();
  }
  void Append() {
    const int block = problem.AddParameterBlock(2);
    if (blocks.empty()) {
      problem.AddResidualBlock(Anchor(10), nullptr, {block});
    } else {
      problem.AddResidualBlock(std::make_shared<BetweenCost>(Between{1}), nullptr, {blocks.back(), block});
    }
    blocks.push_back(block);
  }
  void ExpectSolved() {
    const LmSummary summary = SolveLm(problem);
    EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      for (const int i : {0, 1}) {
        EXPECT_NEAR(problem.Get(blocks[k])[static_cast<std::size_t>(i)], 10 - static_cast<double>(k) * (1 + i), 1e-6);
      }
    }
  }
  BlockProblem problem;
  std::vector<int> blocks;
};

TEST(ProblemBlocks, AProblemGrowsAfterASolve) {
  Chain chain(3);
  chain.ExpectSolved();
  const Index offset = chain.problem.offset(chain.blocks[1]);
  const double before = chain.problem.Get(chain.blocks[1])[0];
  chain.Append();
  EXPECT_EQ(chain.problem.num_parameters(), 8);
  EXPECT_EQ(chain.problem.offset(chain.blocks[1]), offset);
  EXPECT_EQ(chain.problem.Get(chain.blocks[1])[0], before);
  EXPECT_EQ(chain.problem.Get(chain.blocks[3])[0], 0);
  chain.ExpectSolved();
}

// x does not grow, and indices are reused.
TEST(ProblemBlocks, ASlidingWindowDoesNotGrow) {
  Chain chain(5);
  BlockProblem& problem = chain.problem;
  chain.ExpectSolved();
  for (int turn = 0; turn < 20; ++turn) {
    const std::vector<double> anchor(problem.Get(chain.blocks[1]).begin(), problem.Get(chain.blocks[1]).end());
    problem.SetBounds(chain.blocks[0], 1, -1, 1e9);
    problem.RemoveParameterBlock(chain.blocks[0]);
    chain.blocks.erase(chain.blocks.begin());
    EXPECT_EQ(problem.num_residual_blocks(), 3);
    problem.AddResidualBlock(Anchor(anchor[0]), nullptr, {chain.blocks[0]});
    chain.Append();
    EXPECT_EQ(problem.num_parameter_blocks(), 5);
    EXPECT_EQ(problem.num_residual_blocks(), 5);
    EXPECT_EQ(problem.lower_bound(chain.blocks.back(), 1), -std::numeric_limits<double>::infinity());
    const LmSummary summary = SolveLm(problem);
    EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
    EXPECT_NEAR(problem.Get(chain.blocks.back())[0], anchor[0] - 4, 1e-6);
  }
  EXPECT_EQ(problem.num_parameters(), 10);
  EXPECT_EQ(problem.residual_blocks(), (std::vector<Index>{0, 1, 2, 3, 4}));
}

// The result equals that of a problem which never had the removed blocks.
TEST(ProblemBlocks, RemovedBlocksHaveNoEffect) {
  Chain chain(4), with(4);
  BlockProblem& problem = with.problem;
  const int extra = problem.AddParameterBlock(2), other = problem.AddParameterBlock(3);
  problem.AddResidualBlock(std::make_shared<BetweenCost>(Between{7}), nullptr, {with.blocks[0], extra});
  const Index residual_block =
      problem.AddResidualBlock(std::make_shared<BetweenCost>(Between{-3}), nullptr, {with.blocks[3], with.blocks[0]});
  problem.RemoveResidualBlock(residual_block);
  problem.RemoveParameterBlock(extra);
  problem.RemoveParameterBlock(other);
  EXPECT_EQ(problem.num_tangent(), chain.problem.num_tangent());
  EXPECT_EQ(problem.num_units(), 4);
  chain.ExpectSolved(), with.ExpectSolved();
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(problem.Get(with.blocks[k])[0], chain.problem.Get(chain.blocks[k])[0]);
  EXPECT_THAT([&] { problem.Get(extra); }, ThrowsError(kBadArgument));
  EXPECT_THAT([&] { problem.AddResidualBlock(Anchor(1), nullptr, {extra}); }, ThrowsError(kBadArgument));
  EXPECT_EQ(problem.DescribeNonFinite(problem.Gather(), true), "");
}

TEST(ProblemBlocks, QueriesReturnTheArguments) {
  BlockProblem problem;
  const auto manifold = std::make_shared<SubsetManifold>(2, std::vector<int>{1});
  const auto cost = std::make_shared<BetweenCost>(Between{1});
  const auto loss = std::make_shared<HuberLoss>(1.0);
  const int p = problem.AddParameterBlock(2, manifold), q = problem.AddParameterBlock(2);
  problem.SetConstant(q);
  EXPECT_EQ(problem.residual_blocks_of(p), std::vector<Index>());
  const Index first = problem.AddResidualBlock(cost, loss, {q, p});
  const Index second = problem.AddResidualBlock(Anchor(1), nullptr, {p});
  EXPECT_EQ(problem.lower_bound(p, 0), -std::numeric_limits<double>::infinity());
  problem.SetBounds(p, 1, -2, 3);
  EXPECT_EQ(problem.lower_bound(p, 1), -2);
  EXPECT_EQ(problem.upper_bound(p, 1), 3);
  EXPECT_EQ(problem.manifold(p), manifold);
  EXPECT_EQ(problem.manifold(q), nullptr);
  EXPECT_FALSE(problem.is_constant(p));
  EXPECT_TRUE(problem.is_constant(q));
  EXPECT_EQ(problem.cost_function(first), cost);
  EXPECT_EQ(problem.loss(first), loss);
  EXPECT_EQ(problem.loss(second), nullptr);
  EXPECT_EQ(problem.parameter_blocks(), (std::vector<int>{p, q}));
  EXPECT_EQ(problem.parameter_blocks_of(first)[0], q);
  EXPECT_EQ(problem.residual_blocks_of(p), (std::vector<Index>{first, second}));
  EXPECT_EQ(problem.residual_blocks_of(q), std::vector<Index>{first});
  EXPECT_THAT([&] { problem.upper_bound(p, 2); }, ThrowsError(kBadArgument));
  EXPECT_THAT([&] { problem.loss(2); }, ThrowsError(kBadArgument));
  EXPECT_THAT([&] { problem.residual_blocks_of(2); }, ThrowsError(kBadArgument));
}

TEST(ProblemBlocks, ValuesMayBeInTheCallersMemory) {
  BlockProblem problem;
  double p[2] = {5, 5};
  const int first = problem.AddParameterBlock(p, 2), second = problem.AddParameterBlock(2);
  problem.AddResidualBlock(Anchor(10), nullptr, {first});
  problem.AddResidualBlock(std::make_shared<BetweenCost>(Between{1}), nullptr, {first, second});
  const double start[2] = {7, 8};
  problem.Set(second, start);
  p[0] = 6;
  EXPECT_EQ(problem.Get(first).data(), p);
  EXPECT_EQ(problem.FindParameterBlock(p), first);
  const auto x = problem.Gather();
  EXPECT_EQ(std::vector<double>(x.data(), x.data() + x.size()), (std::vector<double>{6, 5, 7, 8}));
  EXPECT_TRUE(IsConverged(SolveLm(problem).status));
  EXPECT_NEAR(p[0], 10, 1e-9);
  EXPECT_NEAR(problem.Get(second)[1], 8, 1e-9);
  EXPECT_THAT([&] { problem.AddParameterBlock(p, 2); }, ThrowsError(kBadArgument));
  EXPECT_THAT([&] { problem.AddParameterBlock(static_cast<double*>(nullptr), 2); }, ThrowsError(kBadArgument));
  problem.RemoveParameterBlock(first);
  EXPECT_THAT([&] { problem.FindParameterBlock(p); }, ThrowsError(kBadArgument));
  EXPECT_EQ(problem.Get(problem.AddParameterBlock(2))[0], 0) << "reuses the index, not the memory";
}

// A chain as a vector of cost functions beside a prior, a manifold and a constant block.
TEST(ProblemBlocks, CostFunctionsOfOneTypeShareAVector) {
  const auto build = [](int way) {
    auto problem = std::make_unique<BlockProblem>();
    std::vector<int> pairs;
    std::vector<BetweenCost> costs;
    std::vector<JoinedCost> joined;
    for (int k = 0; k < 9; ++k) problem->AddParameterBlock(2);
    const auto loss = std::make_shared<CauchyLoss>(0.7);
    for (int k = 0; k < 8; ++k) {
      const double value = std::sin(k);
      pairs.insert(pairs.end(), {k, k + 1});
      costs.emplace_back(Between{value});
      joined.emplace_back(BetweenJoined{value});
      if (way == 0) problem->AddResidualBlock(std::make_shared<BetweenCost>(Between{value}), loss, {k, k + 1});
    }
    if (way == 1) {
      EXPECT_EQ(problem->AddResidualBlocks(std::move(costs), pairs, loss),
                (std::vector<Index>{0, 1, 2, 3, 4, 5, 6, 7}));
    }
    if (way == 2) problem->AddResidualBlocks(std::move(joined), pairs, loss);
    problem->AddResidualBlock(Anchor(3), nullptr, {0});
    problem->SetManifold(3, std::make_shared<SubsetManifold>(2, std::vector<int>{0}));
    problem->SetConstant(8);
    problem->RemoveResidualBlock(5);
    return problem;
  };
  const auto one_by_one = build(0);
  const LmSummary expected = SolveLm(*one_by_one);
  for (const int way : {1, 2}) {
    const auto problem = build(way);
    const LmSummary summary = SolveLm(*problem);
    EXPECT_EQ(summary.final_cost, expected.final_cost);
    EXPECT_EQ(summary.iterations.size(), expected.iterations.size());
    for (int k = 0; k < 9; ++k) EXPECT_EQ(problem->Get(k)[1], one_by_one->Get(k)[1]);
  }
  BlockProblem problem;
  problem.AddParameterBlock(2);
  std::vector<BetweenCost> costs;
  costs.emplace_back(Between{1});
  const std::vector<int> too_few = {0};
  EXPECT_THAT([&] { problem.AddResidualBlocks(std::move(costs), too_few); }, ThrowsError(kBadArgument));
}

TEST(ProblemBlocks, CallbacksSeeTheCurrentPoint) {
  Chain chain(3);
  BlockProblem& problem = chain.problem;
  std::vector<double> costs, records;
  const LmSummary summary = SolveLm(problem, LmOptions(), [&](const LmIteration& row, Cpu::ConstVectorView x) {
    costs.push_back(problem.Cost(x));
    records.push_back(row.cost);
    problem.Scatter(x);
    EXPECT_EQ(problem.Get(chain.blocks[2])[0], x[problem.offset(chain.blocks[2])]);
    return CallbackResult::kContinue;
  });
  EXPECT_EQ(costs.size(), summary.iterations.size());
  EXPECT_EQ(costs, records);
  EXPECT_LT(costs.back(), costs.front());
  int calls = 0;
  std::vector<double> x(6);
  const LmCallback stop = [&](const LmIteration&) { return ++calls, CallbackResult::kStop; };
  EXPECT_EQ(SolveLm(problem, x, LmOptions(), stop).status, LmStatus::kStoppedByCallback);
  EXPECT_EQ(calls, 1);
  EXPECT_TRUE(IsConverged(SolveLm(problem, x, LmOptions(), LmCallback()).status)) << "an empty callback is none";
}

struct Root {
  template <class T>
  bool operator()(const T* p, T* r) const {
    r[0] = p[0];
    return p[0] > T(0.0);
  }
};

TEST(Evaluate, MarksUndefinedResiduals) {
  BlockProblem problem;
  const int first = problem.AddParameterBlock(1), second = problem.AddParameterBlock(1);
  for (const int block : {first, second}) {
    problem.AddResidualBlock(std::make_shared<AutoDiffCost<Root, 1, 1>>(), nullptr, {block});
  }
  std::vector<double> x = {-1, 2};
  const Cpu::ConstVectorView at(x.data(), 2);
  for (const bool derivatives : {true, false}) {
    const BlockEvaluation result = Evaluate(problem, at, {.derivatives = derivatives});
    EXPECT_TRUE(std::isnan(result.cost));
    EXPECT_TRUE(std::isnan(result.residuals[0]));
    EXPECT_EQ(result.residuals[1], 2);
    EXPECT_EQ(result.gradient.size(), derivatives ? 2U : 0U);
    EXPECT_EQ(result.jacobian.rows, derivatives ? 2 : 0);
  }
  const BlockEvaluation one = Evaluate(problem, at, {.residual_blocks = std::vector<Index>{1}});
  EXPECT_EQ(one.cost, 2);
  EXPECT_EQ(one.gradient, (std::vector<double>{0, 2}));
  EXPECT_EQ(one.jacobian.row_starts, (std::vector<Index>{0, 1}));
  EXPECT_EQ(one.jacobian.columns, (std::vector<Index>{1}));
  const BlockEvaluation none = Evaluate(problem, at, {.residual_blocks = std::vector<Index>()});
  EXPECT_EQ(none.cost, 0);
  EXPECT_TRUE(none.residuals.empty());
  const auto evaluate = [&](const EvaluateOptions& options) {
    return [&, options] { Evaluate(problem, at, options); };
  };
  EXPECT_THAT(evaluate({.residual_blocks = std::vector<Index>{2}}), ThrowsError(kBadArgument));
  EXPECT_THAT(evaluate({.parameter_blocks = std::vector<int>{2}}), ThrowsError(kBadArgument));
  EXPECT_THAT(evaluate({.parameter_blocks = std::vector<int>{0, 0}}), ThrowsError(kBadArgument));
  EXPECT_THAT([&] { Evaluate(problem, Cpu::ConstVectorView(x.data(), 1)); }, ThrowsError(kBadArgument));
}

}  // namespace
}  // namespace vesta
