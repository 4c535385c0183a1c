// SPDX-License-Identifier: Apache-2.0
// Levenberg-Marquardt fits a perturbed model to the images of the original.
#include <gtest/gtest.h>

#include <limits>

#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "solver/levenberg_marquardt.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"

namespace vesta::gs {
namespace {

// The start is the perturbed model.
struct FitBack {
  test::RingProblem<float> ring{4, 30, 1, 100};
  FitBack() {
    Scene scene = test::RingOfCameras(4, 40, 30, false);
    const SplatModel truth = test::RandomModel(30, 1, 100);
    test::RenderTruth(truth, 0, &scene);
    const SplatModel start = test::Perturbed(truth, 0.05, 101);
    std::copy(start.data.begin(), start.data.end(), ring.x.begin());
    ring.options.background = {0, 0, 0};
    ring.options.weights.l1_floor = 1e-3;
    for (std::size_t v = 0; v < scene.views.size(); ++v) {
      std::copy(scene.views[v].image.rgb.begin(), scene.views[v].image.rgb.end(), ring.truth[v].begin());
    }
  }
};

vesta::LmOptions SplatLmOptions(StepRule rule) {
  vesta::LmOptions options;
  options.max_iterations = 12;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 0;
  options.SetStepRule(rule);
  options.column_scaling = ColumnScaling::kNone;
  options.normal_system.metric.group_median_floor = 1e-6;
  options.normal_system.preconditioner = PreconditionerKind::kBlockJacobi;
  options.normal_system.pcg.max_iterations = 10;
  return options;
}

// Accepted steps lower the cost, rejected ones keep it, and the reported final cost belongs to the returned x.
void ExpectDescent(FitBack& fit, const vesta::LmOptions& options, double most_of_initial_cost) {
  SplatProblem<CpuBackend<float>> problem = fit.ring.Make();
  CpuBackend<float> backend;
  const LmSummary summary = SolveLm<CpuBackend<float>>(options, backend, problem, fit.ring.x);
  ASSERT_GT(summary.num_accepted, 0);
  for (std::size_t i = 1; i < summary.iterations.size(); ++i) {
    const double before = summary.iterations[i - 1].cost, after = summary.iterations[i].cost;
    if (summary.iterations[i].accepted) {
      EXPECT_LT(after, before) << "iteration " << i;
    } else {
      EXPECT_EQ(after, before) << "iteration " << i;
    }
  }
  EXPECT_EQ(problem.Cost(fit.ring.x), summary.final_cost);
  EXPECT_LT(summary.final_cost, most_of_initial_cost * summary.initial_cost) << summary.FullReport();
}

TEST(SplatSolve, EveryStepRuleFitsAModelBackToItsImages) {
  for (const StepRule rule : {StepRule::kCeres, StepRule::k3dgsLmCode, StepRule::k3dgsLmV2}) {
    SCOPED_TRACE(ToString(rule));
    FitBack fit;
    ExpectDescent(fit, SplatLmOptions(rule), rule == StepRule::kCeres ? 0.1 : 0.5);
  }
}

TEST(SplatSolve, BatchesDescendMergedAndAsOneSystem) {
  for (const BatchMode mode : {BatchMode::kMerge, BatchMode::kExact}) {
    for (const LmDamping damping : {LmDamping::kLearningRates, LmDamping::kDiagonal}) {
      SCOPED_TRACE(testing::Message() << ToString(mode) << ", damping " << static_cast<int>(damping));
      FitBack fit;
      fit.ring.options.batches.count = 2;
      fit.ring.options.damping = damping;
      vesta::LmOptions options = SplatLmOptions(StepRule::kCeres);
      options.batch_mode = mode;
      options.line_search.enabled = mode == BatchMode::kMerge;
      ExpectDescent(fit, options, 0.8);
    }
  }
}

// The solver still optimises all others.
TEST(SplatSolve, AGaussianThatIsNotFiniteStopsNobodyElse) {
  FitBack fit;
  fit.ring.x[4] = std::numeric_limits<float>::quiet_NaN();
  ExpectDescent(fit, SplatLmOptions(StepRule::kCeres), 0.8);
}

}  // namespace
}  // namespace vesta::gs
