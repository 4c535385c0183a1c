// SPDX-License-Identifier: Apache-2.0
#include "solver/distributed/block_parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mutex>

#include "kernels/core/check.h"
#include "solver/distributed/distributed_problem.h"
#include "solver/levenberg_marquardt.h"
#include "tests/solver/distributed/chain.h"
#include "tests/support/linearize_at.h"
#include "tests/support/thread_ranks.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

using test::Chain;
using test::Cpu;
using test::PcgOptionsOf;
using test::ViewOf;
using testing::HasSubstr;

struct Solved {
  std::vector<double> x;
  LmSummary summary;
};

// By the rank 0 of so many; all ranks end at the same.
Solved SolveOn(int count, bool bounded) {
  Solved solved;
  std::mutex mutex;
  std::vector<std::vector<double>> all;
  test::OnThreadRanks(count, [&](Communicator& ranks) {
    Chain chain(bounded);
    BlockParts parts(chain.problem, 16);
    DistributedProblem<Cpu> problem(ranks, parts);
    Cpu backend;
    const LmSummary summary = SolveLm<Cpu>(PcgOptionsOf(), backend, problem, ViewOf(chain.x));
    const std::lock_guard lock(mutex);
    all.push_back(chain.x);
    if (ranks.rank() == 0) solved.summary = summary;
  });
  for (const auto& x : all) EXPECT_EQ(x, all.front());
  solved.x = all.front();
  return solved;
}

TEST(BlockParts, SolveToTheMinimumOfTheWhole) {
  for (const bool bounded : {false, true}) {
    Chain chain(bounded);
    Cpu backend;
    const LmSummary whole = SolveLm<Cpu>(PcgOptionsOf(), backend, chain.problem, ViewOf(chain.x));
    const Solved solved = SolveOn(3, bounded);
    EXPECT_NEAR(solved.summary.final_cost, whole.final_cost, 1e-7 * whole.final_cost);
    EXPECT_LT(solved.summary.final_cost, 0.5 * solved.summary.initial_cost);
    EXPECT_EQ(solved.summary.num_residuals, whole.num_residuals);
    if (bounded) {
      EXPECT_LE(solved.x[10], 4.6);
    }
  }
}

TEST(BlockParts, GiveTheSameBitsOnAnyNumberOfRanks) {
  const std::vector<double> alone = SolveOn(1, false).x;
  for (const int count : {2, 3, 4, 8}) EXPECT_EQ(SolveOn(count, false).x, alone) << count << " ranks";
}

TEST(BlockParts, AddUpToTheWhole) {
  test::OnThreadRanks(3, [](Communicator& ranks) {
    Chain chain;
    BlockParts parts(chain.problem, 11);
    DistributedProblem<Cpu> problem(ranks, parts);
    const Index n = problem.num_tangent();
    auto whole = LinearizeAt(chain.problem, ViewOf(chain.x));
    auto distributed = LinearizeAt(problem, ViewOf(chain.x));
    EXPECT_EQ(distributed->num_residuals(), whole->num_residuals());
    EXPECT_NEAR(problem.Cost(ViewOf(chain.x)), chain.problem.Cost(ViewOf(chain.x)), 1e-12);
    const std::vector<Index> some{0, 3, 4, 30, 61};
    EXPECT_NEAR(problem.Cost(ViewOf(chain.x), some), chain.problem.Cost(ViewOf(chain.x), some), 1e-12);
    Cpu::Vector v(n), a(n), b(n);
    for (Index k = 0; k < n; ++k) v[k] = 0.01 * static_cast<double>((5 * k) % 13) - 0.05;
    const auto expect_equal = [&](const char* what) {
      for (Index k = 0; k < n; ++k) EXPECT_NEAR(a[k], b[k], 1e-11) << what << " " << k;
    };
    whole->ApplyH(v, a), distributed->ApplyH(v, b);
    expect_equal("H v");
    EXPECT_NEAR(distributed->Curvature(v), whole->Curvature(v), 1e-11);
    whole->Gradient(a), distributed->Gradient(b);
    expect_equal("gradient");
    whole->DiagJTJ(a), distributed->DiagJTJ(b);
    expect_equal("diagonal");
    BlockDiagonal<Cpu> blocks(n, whole->block_groups()), sum(n, distributed->block_groups());
    whole->BlockGram(blocks), distributed->BlockGram(sum);
    blocks.Apply(v, a), sum.Apply(v, b);
    expect_equal("blocks");
  });
}

TEST(BlockParts, AreRefusedWithAWord) {
  Chain chain;
  EXPECT_THAT([&] { BlockParts(chain.problem, 0); }, ThrowsError(kBadArgument, "1"));
  chain.problem.set_evaluation_callback([](auto, bool) {});
  EXPECT_THAT([&] { BlockParts(chain.problem, 4); }, ThrowsError(kUnsupported));
}

TEST(DistributedProblem, StopsOnAllRanksWhereOneSaysSo) {
  test::OnThreadRanks(2, [](Communicator& ranks) {
    Chain chain;
    BlockParts parts(chain.problem, 8);
    DistributedProblem<Cpu> problem(ranks, parts);
    Cpu backend;
    const LmSummary summary =
        SolveLm<Cpu>(PcgOptionsOf(), backend, problem, ViewOf(chain.x), [&](const LmIteration& row) {
          return ranks.rank() == 1 && row.iteration == 2 ? CallbackResult::kStop : CallbackResult::kContinue;
        });
    EXPECT_EQ(summary.status, LmStatus::kStoppedByCallback);
    EXPECT_EQ(summary.iterations.back().iteration, 2);
  });
}

TEST(DistributedProblem, NamesThePartThatIsNotFinite) {
  test::OnThreadRanks(2, [](Communicator& ranks) {
    Chain chain;
    BlockParts parts(chain.problem, 8);
    DistributedProblem<Cpu> problem(ranks, parts);
    chain.x[2 * 35] = std::numeric_limits<double>::quiet_NaN();
    Cpu backend;
    const LmSummary summary = SolveLm<Cpu>(PcgOptionsOf(), backend, problem, ViewOf(chain.x));
    EXPECT_EQ(summary.status, LmStatus::kNonFinite);
    EXPECT_THAT(summary.message, HasSubstr("part "));
  });
}

TEST(DistributedProblem, RefusesSolversThatNeedAllResiduals) {
  const auto solve = [](LinearSolverKind kind) {
    test::OnThreadRanks(2, [kind](Communicator& ranks) {
      Chain chain;
      BlockParts parts(chain.problem, 8);
      DistributedProblem<Cpu> problem(ranks, parts);
      Cpu backend;
      LmOptions options;
      options.normal_system.linear_solver = kind;
      SolveLm<Cpu>(options, backend, problem, ViewOf(chain.x));
    });
  };
  EXPECT_THAT([&] { solve(LinearSolverKind::kDenseQr); }, ThrowsError(kUnsupported));
  EXPECT_NO_THROW(solve(LinearSolverKind::kAuto));
}

}  // namespace
}  // namespace vesta
