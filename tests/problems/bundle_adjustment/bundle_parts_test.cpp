// SPDX-License-Identifier: Apache-2.0
#include "problems/bundle_adjustment/bundle_parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mutex>

#include "bench/collections/generate_bundle.h"
#include "kernels/core/check.h"
#include "solver/distributed/distributed_problem.h"
#include "solver/levenberg_marquardt.h"
#include "solver/reduced_system.h"
#include "tests/support/linearize_at.h"
#include "tests/support/thread_ranks.h"
#include "tests/support/throws_error.h"

namespace vesta::bundle {
namespace {

using Cpu = CpuBackend<double>;

BundleData Street() { return Generate({.num_cameras = 12, .num_points = 400, .mean_track = 4, .seed = 3}); }
HostSpan<double> ViewOf(std::vector<double>& x) { return {x.data(), static_cast<Index>(x.size())}; }

std::vector<double> SolveOn(int count, LinearSolverKind kind, double tolerance = 1e-6, double* cost = nullptr) {
  std::mutex mutex;
  std::vector<std::vector<double>> all;
  test::OnThreadRanks(count, [&](Communicator& ranks) {
    BundleData data = Street();
    BundleParts parts(data, 16);
    DistributedProblem<Cpu> problem(ranks, parts);
    LmOptions options = BundleLmOptions();
    options.function_tolerance = tolerance;
    options.normal_system.linear_solver = kind;
    if (kind == LinearSolverKind::kPcg) options.normal_system.preconditioner = PreconditionerKind::kBlockJacobi;
    Cpu backend;
    const LmSummary summary = SolveLm<Cpu>(options, backend, problem, ViewOf(data.x));
    const std::lock_guard lock(mutex);
    all.push_back(data.x);
    if (cost != nullptr) *cost = summary.final_cost;
  });
  for (const auto& x : all) EXPECT_EQ(x, all.front());
  return all.front();
}

TEST(BundleParts, SolveToTheMinimumOfTheWhole) {
  BundleData data = Street();
  BundleProblem whole(data);
  Cpu backend;
  constexpr double kTolerance = 1e-9;  // linear systems are solved to different accuracy
  LmOptions options = BundleLmOptions();
  options.function_tolerance = kTolerance;
  const LmSummary expected = SolveLm<Cpu>(options, backend, whole, ViewOf(data.x));
  double cost = 0;
  SolveOn(3, LinearSolverKind::kReducedPcg, kTolerance, &cost);
  EXPECT_NEAR(cost, expected.final_cost, 1e-6 * expected.final_cost);
}

TEST(BundleParts, GiveTheSameBitsOnAnyNumberOfRanks) {
  for (const LinearSolverKind kind : {LinearSolverKind::kReducedPcg, LinearSolverKind::kPcg}) {
    const std::vector<double> alone = SolveOn(1, kind);
    for (const int count : {2, 3, 4, 8}) EXPECT_EQ(SolveOn(count, kind), alone) << count << " ranks";
  }
}

TEST(BundleParts, ReduceToTheSystemOfTheWhole) {
  test::OnThreadRanks(2, [](Communicator& ranks) {
    BundleData data = Street();
    BundleParts parts(data, 7);
    DistributedProblem<Cpu> problem(ranks, parts);
    BundleProblem whole(data, {.reduced_form = ReducedForm::kImplicit});
    const auto a = LinearizeAt(whole, ViewOf(data.x)), b = LinearizeAt(problem, ViewOf(data.x));
    const auto reduced = a->MakeReducedSystem(), distributed = b->MakeReducedSystem();
    ASSERT_EQ(reduced->size(), distributed->size());
    const Index n = problem.num_tangent(), kept = reduced->size();
    Cpu backend;
    Cpu::Vector metric(n), g(n), x(kept), ya(kept), yb(kept), step_a(n), step_b(n);
    a->DiagJTJ(metric);
    a->Gradient(g);
    reduced->SetDamping(1e-2, metric), distributed->SetDamping(1e-2, metric);
    const auto expect_equal = [&](const Cpu::Vector& p, const Cpu::Vector& q, const char* what) {
      const double scale = backend.MaxAbs(p);
      for (Index k = 0; k < p.size(); ++k) ASSERT_NEAR(p[k], q[k], 1e-9 * scale) << what << " " << k;
    };
    for (Index k = 0; k < kept; ++k) x[k] = 1e-3 * static_cast<double>((7 * k) % 11) - 5e-3;
    reduced->Apply(x, ya), distributed->Apply(x, yb);
    expect_equal(ya, yb, "S x");
    reduced->ReduceRhs(g, ya), distributed->ReduceRhs(g, yb);
    expect_equal(ya, yb, "right-hand side");
    backend.Copy(x, step_a.view().subspan(0, kept)), backend.Copy(x, step_b.view().subspan(0, kept));
    reduced->BackSubstitute(g, step_a), distributed->BackSubstitute(g, step_b);
    expect_equal(step_a, step_b, "step");
    BlockDiagonal<Cpu> blocks(kept, reduced->kept_groups()), sum(kept, distributed->kept_groups());
    reduced->DiagonalBlocks(blocks), distributed->DiagonalBlocks(sum);
    blocks.Apply(x, ya), sum.Apply(x, yb);
    expect_equal(ya, yb, "blocks");
  });
}

TEST(BundleParts, OfNoPointsIsOne) {
  BundleData data;
  data.num_cameras = 2;
  data.x.resize(18);
  BundleParts parts(data, 4);
  ASSERT_EQ(parts.num_parts(), 1);
  EXPECT_EQ(parts.Make(0).problem->num_parameters(), 18);
}

TEST(BundleParts, HaveAtLeastAPointEach) {
  BundleData data = Street();
  EXPECT_EQ(BundleParts(data, 100000).num_parts(), 400);
  EXPECT_THAT([&] { BundleParts(data, 0); }, ThrowsError(kBadArgument, "1"));
  BundleParts parts(data, 9);
  Index observations = 0;
  for (int k = 0; k < 9; ++k) {
    const auto made = parts.Make(k);
    observations += static_cast<BundleProblem&>(*made.problem).structure().num_observations();
  }
  EXPECT_EQ(observations, static_cast<Index>(data.observations.size()));
}

}  // namespace
}  // namespace vesta::bundle
