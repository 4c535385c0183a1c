// Parts as if they were evaluated in another memory space, which is the host's own here: the same numbers as without.
#include "solver/distributed/hosted_parts.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "solver/distributed/block_parts.h"
#include "solver/distributed/distributed_problem.h"
#include "solver/levenberg_marquardt.h"
#include "tests/solver/distributed/chain.h"
#include "tests/support/thread_ranks.h"

namespace vesta {
namespace {

using test::Chain;
using test::Cpu;
using test::ViewOf;

std::vector<double> Values(HostSpan<const double> v) { return {v.begin(), v.end()}; }

// Of the first rank of three.
std::vector<double> Solve(bool hosted, bool bounded) {
  std::vector<double> x;
  test::OnThreadRanks(3, [&](Ranks& ranks) {
    Chain chain(bounded);
    BlockParts parts(chain.problem, 16);
    HostedParts<Cpu> hosted_parts(parts);
    ProblemParts<Cpu>& chosen = hosted ? static_cast<ProblemParts<Cpu>&>(hosted_parts) : parts;
    DistributedProblem<Cpu> problem(ranks, chosen);
    Cpu backend;
    SolveLm<Cpu>(test::PcgOptionsOf(), backend, problem, ViewOf(chain.x));
    if (ranks.rank() == 0) x = chain.x;
  });
  return x;
}

TEST(HostedParts, SolveToTheSameBits) {
  for (const bool bounded : {false, true}) EXPECT_EQ(Solve(true, bounded), Solve(false, bounded));
}

class HostedProblems : public testing::Test {
 protected:
  HostedProblems() {
    for (Index k = 0; k < n_; ++k) step_[k] = 0.3 * static_cast<double>((5 * k) % 13) - 1.5;
  }

  Chain chain_{true};
  HostedProblem<Cpu> hosted_{std::make_shared<HostedVectors<Cpu>>(), chain_.problem};
  const Index n_ = chain_.problem.num_tangent();
  Cpu::Vector step_{n_}, a_{n_}, b_{n_};
};

TEST_F(HostedProblems, LinearizeAlike) {
  auto there = chain_.problem.Linearize(ViewOf(chain_.x), 0), here = hosted_.Linearize(ViewOf(chain_.x), 0);
  ASSERT_EQ(here->num_residuals(), there->num_residuals());
  EXPECT_EQ(Values(here->residuals()), Values(there->residuals()));
  Cpu::Vector u(there->num_residuals()), other(there->num_residuals());
  there->ApplyJ(step_, u), here->ApplyJ(step_, other);
  EXPECT_EQ(Values(other), Values(u));
  there->ApplyW(u, other);
  Cpu::Vector weighted(u.size());
  here->ApplyW(u, weighted);
  EXPECT_EQ(Values(weighted), Values(other));
  const auto expect_equal = [&](const char* what) { EXPECT_EQ(Values(b_), Values(a_)) << what; };
  there->ApplyJT(u, a_), here->ApplyJT(u, b_);
  expect_equal("J^T u");
  there->ApplyH(step_, a_), here->ApplyH(step_, b_);
  expect_equal("H v");
  there->Gradient(a_), here->Gradient(b_);
  expect_equal("gradient");
  there->Descent(a_), here->Descent(b_);
  expect_equal("descent");
  there->DiagJTJ(a_), here->DiagJTJ(b_);
  expect_equal("diagonal");
  EXPECT_EQ(here->Curvature(step_), there->Curvature(step_));
  BlockDiagonal<Cpu> blocks(n_, there->block_groups()), same(n_, here->block_groups());
  there->BlockGram(blocks), here->BlockGram(same);
  EXPECT_EQ(Values(same.all_values()), Values(blocks.all_values()));
}

// While a linearization is there a copy of its x is shared, and another x gets another.
TEST_F(HostedProblems, KeepTheXThatTheyWereLinearizedAt) {
  auto first = hosted_.Linearize(ViewOf(chain_.x), 0), same = hosted_.Linearize(ViewOf(chain_.x), 0);
  std::vector<double> moved = chain_.x;
  for (double& value : moved) value += 0.01;
  auto other = hosted_.Linearize(ViewOf(moved), 0);
  auto expected = chain_.problem.Linearize(ViewOf(moved), 0);
  expected->Gradient(a_), other->Gradient(b_);
  EXPECT_EQ(Values(b_), Values(a_));
  first->Gradient(a_), same->Gradient(b_);
  EXPECT_EQ(Values(b_), Values(a_));
  EXPECT_NE(Values(b_), [&] {
    other->Gradient(a_);
    return Values(a_);
  }());
}

TEST_F(HostedProblems, StepAlike) {
  EXPECT_TRUE(hosted_.has_bounds());
  const std::vector<Index> some{0, 3, 30};
  EXPECT_EQ(hosted_.Cost(ViewOf(chain_.x)), chain_.problem.Cost(ViewOf(chain_.x)));
  EXPECT_EQ(hosted_.Cost(ViewOf(chain_.x), some), chain_.problem.Cost(ViewOf(chain_.x), some));
  Cpu backend;
  std::vector<double> there(chain_.x.size()), here(chain_.x.size());
  chain_.problem.Plus(backend, ViewOf(chain_.x), step_, ViewOf(there));
  hosted_.Plus(backend, ViewOf(chain_.x), step_, ViewOf(here));
  EXPECT_EQ(here, there);
  EXPECT_EQ(hosted_.IsFeasible(ViewOf(here)), chain_.problem.IsFeasible(ViewOf(here)));
  here[10] = 1e6;
  EXPECT_FALSE(hosted_.IsFeasible(ViewOf(here)));

  chain_.x[10] = 4.6;  // at its bound, and the step leads beyond; the first point is constant
  step_[8] = 3;
  const auto both = [&](const auto& call, const char* what) {
    backend.Copy(step_, a_), backend.Copy(step_, b_);
    call(static_cast<Problem<Cpu>&>(chain_.problem), a_.view()), call(hosted_, b_.view());
    EXPECT_EQ(Values(b_), Values(a_)) << what;
  };
  both([&](Problem<Cpu>& p, Cpu::View v) { p.ClipStep(ViewOf(chain_.x), v); }, "clipped");
  EXPECT_NE(Values(b_), Values(step_));
  for (Index k = 0; k < n_; ++k) step_[k] = 1;
  Cpu::Vector descent(n_);
  for (Index k = 0; k < n_; ++k) descent[k] = 1;
  both([&](Problem<Cpu>& p, Cpu::View v) { p.MaskActiveBounds(ViewOf(chain_.x), descent, v); }, "mask");
  EXPECT_NE(Values(b_), Values(step_));
  both([&](Problem<Cpu>& p, Cpu::View v) { EXPECT_FALSE(p.DampingMetric(ViewOf(chain_.x), descent, v)); }, "metric");
  EXPECT_EQ(Values(b_), Values(step_)) << "what is not the problem's own stays";
}

}  // namespace
}  // namespace vesta
