// SPDX-License-Identifier: Apache-2.0
#include "solver/distributed/block_parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <mutex>
#include <vector>

#include "kernels/core/check.h"
#include "solver/distributed/distributed_problem.h"
#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"
#include "tests/support/linearize_at.h"
#include "tests/support/thread_ranks.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

using testing::HasSubstr;
using Cpu = CpuBackend<double>;

// A nonlinear measurement of the offset between two points.
class Way final : public CostFunction {
 public:
  explicit Way(double measured) : CostFunction(2, std::vector<int>{2, 2}), measured_(measured) {}
  bool Evaluate(const double* const* p, double* r, double** jacobians) const override {
    const double dx = p[1][0] - p[0][0], dy = p[1][1] - p[0][1];
    r[0] = dx * dx + dy - measured_;
    r[1] = dy - 0.3 * dx * dy;
    if (jacobians == nullptr) return true;
    const double rows[4] = {2 * dx, 1, -0.3 * dy, 1 - 0.3 * dx};
    for (int side = 0; side < 2; ++side) {
      if (jacobians[side] == nullptr) continue;
      for (int k = 0; k < 4; ++k) jacobians[side][k] = side == 0 ? -rows[k] : rows[k];
    }
    return true;
  }

 private:
  double measured_;
};

// A chain with loops. The first point is constant; one entry of another is bounded if requested.
struct Chain {
  static constexpr int kPoints = 40;
  explicit Chain(bool bounded = false) {
    for (int i = 0; i < kPoints; ++i) problem.AddParameterBlock(2);
    problem.SetConstant(0);
    if (bounded) problem.SetBounds(5, 0, -1, 4.6);
    for (int i = 0; i < kPoints; ++i) {
      for (const int step : {1, 7}) {
        if (i + step >= kPoints) continue;
        problem.AddResidualBlock(std::make_shared<Way>(step + 0.1 * ((7 * i) % 5)), std::make_shared<HuberLoss>(0.5),
                                 {i, i + step});
      }
      x.push_back(0.9 * i);
      x.push_back(0.05 * ((3 * i) % 7));
    }
  }
  BlockProblem problem;
  std::vector<double> x;
};

HostSpan<double> ViewOf(std::vector<double>& x) { return {x.data(), static_cast<Index>(x.size())}; }

LmOptions PcgOptionsOf() {
  LmOptions options;
  options.normal_system.linear_solver = LinearSolverKind::kPcg;
  options.normal_system.preconditioner = PreconditionerKind::kBlockJacobi;
  options.normal_system.pcg.model_tolerance = 1e-6;
  options.max_iterations = 60;
  return options;
}

struct Solved {
  std::vector<double> x;
  LmSummary summary;
};

// Solves on `count` ranks and returns the result of rank 0; all ranks must have the same.
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

// The first points are constant, so some residual blocks have a fixed cost.
TEST(BlockParts, SumTheFixedCost) {
  const auto make_constant = [](Chain& chain) {
    for (int block = 0; block < 10; ++block) chain.problem.SetConstant(block);
  };
  Chain chain;
  make_constant(chain);
  const std::vector<double> start = chain.x;
  Cpu backend;
  const LmSummary whole = SolveLm<Cpu>(PcgOptionsOf(), backend, chain.problem, ViewOf(chain.x));
  ASSERT_GT(whole.fixed_cost, 0);
  test::OnThreadRanks(3, [&](Communicator& ranks) {
    Chain own;
    make_constant(own);
    BlockParts parts(own.problem, 16);
    DistributedProblem<Cpu> problem(ranks, parts);
    EXPECT_NEAR(problem.Cost(ViewOf(own.x)), whole.initial_cost, 1e-12 * whole.initial_cost);
    Cpu on_rank;
    const LmSummary summary = SolveLm<Cpu>(PcgOptionsOf(), on_rank, problem, ViewOf(own.x));
    EXPECT_NEAR(summary.fixed_cost, whole.fixed_cost, 1e-12 * whole.fixed_cost);
    EXPECT_NEAR(summary.initial_cost, whole.initial_cost, 1e-12 * whole.initial_cost);
    EXPECT_NEAR(summary.final_cost, whole.final_cost, 1e-7 * whole.final_cost);
    EXPECT_EQ(summary.num_residuals, whole.num_residuals);
    for (std::size_t k = 0; k < 20; ++k) EXPECT_EQ(own.x[k], start[k]);
    EXPECT_NEAR(problem.VariableNorm(ViewOf(own.x)), own.problem.VariableNorm(ViewOf(own.x)), 0);
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
