// Splats and cameras in parts on several ranks, which are threads of the test, beside the problem that is one.
#include "problems/gaussian_splatting/cameras/joint_parts.h"

#include <gtest/gtest.h>

#include <mutex>

#include "kernels/core/error.h"
#include "solver/distributed/distributed_problem.h"
#include "solver/distributed/hosted_parts.h"
#include "solver/levenberg_marquardt.h"
#include "solver/normal_equations/reduced_system.h"
#include "tests/problems/gaussian_splatting/cameras/joint_setup.h"
#include "tests/support/thread_ranks.h"

namespace vesta::gs {
namespace {

using B = CpuBackend<double>;

constexpr int kViews = 5;

test::JointSetup<double> SetupOf(bool eliminate_views, const FreeUnknowns& free = {true, true}) {
  test::JointSetup<double> setup(free, kViews, 20, 1, 3);
  setup.options.eliminate_views = eliminate_views;
  setup.options.splats.view_agreement = 0.3;
  return setup;
}

// All that an engine asks for at one x, one after the other.
std::vector<double> Asked(Problem<B>& problem, const std::vector<BlockGroup>& groups, B::ConstView x) {
  std::vector<double> told{problem.Cost(x), problem.Cost(x, std::vector<Index>{1, 3, 4})};
  const Index n = problem.num_tangent();
  const auto linearization = problem.Linearize(x, 0);
  EXPECT_TRUE(linearization->has_own_descent());
  HostBuffer<double> g(n), d(n), v(n), Hv(n);
  const auto tell = [&](B::ConstView values) { told.insert(told.end(), values.begin(), values.end()); };
  linearization->Gradient(g.view()), tell(g.view());
  linearization->Descent(d.view()), tell(d.view());
  for (Index k = 0; k < n; ++k) v[k] = 0.01 * static_cast<double>(k % 7 - 3);
  HostBuffer<double> metric(n);
  linearization->DiagJTJ(metric.view()), tell(metric.view());
  HostBuffer<double> damping(n);
  EXPECT_TRUE(problem.DampingMetric(x, metric.view(), damping.view()));
  tell(damping.view());
  linearization->ApplyH(v.view(), Hv.view()), tell(Hv.view());
  told.push_back(linearization->Curvature(v.view()));
  const auto reduced = linearization->MakeReducedSystem();
  if (!reduced) {
    BlockDiagonal<B> blocks(n, groups);
    linearization->BlockGram(blocks), tell(blocks.all_values());
    return told;
  }
  // Damped twice over, as after a step that was refused.
  for (const double lambda : {0.1, 0.5}) {
    HostBuffer<double> rhs(reduced->size()), product(reduced->size()), step(n);
    reduced->SetDamping(lambda, damping.view());
    reduced->ReduceRhs(d.view(), rhs.view()), tell(rhs.view());
    BlockDiagonal<B> blocks(reduced->size(), reduced->kept_groups());
    reduced->DiagonalBlocks(blocks), tell(blocks.all_values());
    reduced->Apply(rhs.view(), product.view()), tell(product.view());
    std::copy(product.begin(), product.end(), step.begin());
    reduced->BackSubstitute(d.view(), step.view()), tell(step.view());
  }
  HostBuffer<double> moved(problem.num_parameters());
  B backend;
  problem.Plus(backend, x, v.view(), moved.view()), tell(moved.view());
  return told;
}

// What tell(problem) gives of the parts on one, two and three ranks, evaluated where they are or as if elsewhere
// (HostedParts): the same bits.
template <class Tell>
std::vector<double> OnAnyNumberOfRanks(const test::JointSetup<double>& setup, const Tell& tell) {
  std::vector<double> of_one;
  for (const int count : {1, 2, 3}) {
    std::mutex mutex;
    vesta::test::OnThreadRanks(count, [&](Ranks& ranks) {
      JointProblem<CpuBackend<double>> whole = setup.Make();
      JointParts<CpuBackend<double>> parts(whole);
      HostedParts<B> hosted(parts);
      DistributedProblem<B> distributed(ranks, count == 2 ? static_cast<ProblemParts<B>&>(hosted) : parts);
      const std::vector<double> told = tell(distributed);
      const std::lock_guard lock(mutex);
      if (of_one.empty()) of_one = told;
      EXPECT_EQ(told, of_one) << count;
    });
  }
  return of_one;
}

void ExpectToBeOne(const test::JointSetup<double>& setup) {
  JointProblem<CpuBackend<double>> whole = setup.Make();
  const auto asked = [&](Problem<B>& problem) { return Asked(problem, whole.block_groups(), setup.x.view()); };
  const std::vector<double> expected = asked(whole), told = OnAnyNumberOfRanks(setup, asked);
  ASSERT_EQ(told.size(), expected.size());
  for (std::size_t k = 0; k < told.size(); ++k) {
    ASSERT_NEAR(told[k], expected[k], 1e-9 * (1e-3 + std::abs(expected[k]))) << k;
  }
}

TEST(JointParts, AreTheProblemThatIsOne) {
  for (const bool eliminates : {true, false}) {
    ExpectToBeOne(SetupOf(eliminates));
    ExpectToBeOne(SetupOf(eliminates, {true, true, true, true}));
  }
}

// As the engine solves it, by PCG with the views eliminated or along with the splats, in shards.
TEST(JointParts, AreSolvedToTheSameBits) {
  for (const bool eliminates : {true, false}) {
    const test::JointSetup<double> setup = SetupOf(eliminates, {true, true, true, true});
    LmOptions options;
    options.max_iterations = 3;
    options.normal_system.linear_solver = eliminates ? LinearSolverKind::kReducedPcg : LinearSolverKind::kPcg;
    const auto solve = [&](Problem<B>& problem) {
      B backend;
      HostBuffer<double> x(setup.x.size());
      std::copy(setup.x.begin(), setup.x.end(), x.begin());
      const LmSummary summary = SolveLm<B>(options, backend, problem, x);
      EXPECT_LT(summary.final_cost, 0.9 * summary.initial_cost);
      return std::vector<double>(x.begin(), x.end());
    };
    const std::vector<double> of_one = OnAnyNumberOfRanks(setup, solve);
    JointProblem<CpuBackend<double>> alone = setup.Make();
    const std::vector<double> x = solve(alone);
    for (std::size_t k = 0; k < x.size(); ++k) ASSERT_NEAR(x[k], of_one[k], 1e-6 * (1 + std::abs(x[k]))) << k;
  }
}

// A part is asked again after what it had was given away: nothing is added up twice.
TEST(JointParts, APartTellsTheSameTwice) {
  const test::JointSetup<double> setup = SetupOf(true);
  JointProblem<CpuBackend<double>> whole = setup.Make();
  JointParts<CpuBackend<double>> parts(whole);
  const ProblemPart<B> part = parts.Make(2);
  const auto linearization = part.problem->Linearize(setup.x.view(), 0);
  const Index n = part.problem->num_tangent();
  HostBuffer<double> first(n), again(n);
  linearization->Gradient(first.view());
  linearization->Gradient(again.view());
  EXPECT_EQ(std::vector(first.begin(), first.end()), std::vector(again.begin(), again.end()));
  linearization->SquaredGradients(first.view());
  linearization->SquaredGradients(again.view());
  EXPECT_EQ(std::vector(first.begin(), first.end()), std::vector(again.begin(), again.end()));
}

// Of views of others there are no photographs.
TEST(JointParts, LookAtTheirOwnViewsAlone) {
  const test::JointSetup<double> setup = SetupOf(true);
  std::vector<TargetView<B>> views(setup.ring.views.begin(), setup.ring.views.end());
  for (int v = 0; v < kViews; ++v) {
    if (v != 2) views[static_cast<std::size_t>(v)].truth = {};
  }
  JointProblem<CpuBackend<double>> lacking(setup.options, views), whole = setup.Make();
  const Index n = JointParts<CpuBackend<double>>(lacking).Make(2).problem->num_tangent();
  HostBuffer<double> of_lacking(n), of_whole(n);
  JointParts<CpuBackend<double>>(lacking).Make(2).problem->Linearize(setup.x.view(), 0)->Gradient(of_lacking.view());
  JointParts<CpuBackend<double>>(whole).Make(2).problem->Linearize(setup.x.view(), 0)->Gradient(of_whole.view());
  EXPECT_EQ(std::vector(of_lacking.begin(), of_lacking.end()), std::vector(of_whole.begin(), of_whole.end()));
  EXPECT_NE(of_whole[n - 1], 0);
  EXPECT_THROW(lacking.Cost(setup.x.view()), Error);
  EXPECT_THROW(lacking.Linearize(setup.x.view(), 0), Error);
}

}  // namespace
}  // namespace vesta::gs
