// SPDX-License-Identifier: Apache-2.0
// Results are bit-identical for any number of threads.
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "solver/internal/derivative_check.inl"
#include "tests/splatting/density/density_scene.h"
#include "tests/splatting/train/synthetic_views.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/any_threads.h"
#include "tests/support/linearize_at.h"

namespace vesta::gs {
namespace {

using vesta::test::ExpectSameForAnyThreads;

// With an evaluation during the training.
TrainOptions ShortTraining(int adam_iterations, int lm_iterations) {
  TrainOptions options = test::ShortTraining(adam_iterations, lm_iterations);
  options.adam.evaluations = 2;
  return options;
}

template <class S>
void CheckProblem() {
  test::RingProblem<S> ring(3, 200, 1, 80);
  ring.options.batches.count = 2;
  ExpectSameForAnyThreads([&] {
    SplatProblem<CpuBackend<S>> problem = ring.Make();
    const Index n = problem.num_parameters();
    HostBuffer<S> v(n);
    CpuBackend<S> backend;
    FillRandom(backend, 81, v.view());
    std::vector<std::vector<S>> results{{static_cast<S>(problem.Cost(ring.x))}};
    const auto keep = [&](const HostBuffer<S>& x) { results.emplace_back(x.begin(), x.end()); };
    for (int batch = 0; batch < 2; ++batch) {
      const auto linearization = LinearizeAt(problem, ring.x, batch);
      HostBuffer<S> out(n);
      linearization->Gradient(out);
      keep(out);
      linearization->ApplyH(v, out);
      keep(out);
      linearization->DiagJTJ(out);
      keep(out);
      HostBuffer<S> metric(n);
      EXPECT_TRUE(problem.DampingMetric(ring.x, out, metric));
      keep(metric);
      BlockDiagonal<CpuBackend<S>> blocks(n, linearization->block_groups());
      linearization->BlockGram(blocks);
      results.emplace_back(blocks.all_values().begin(), blocks.all_values().end());
    }
    return results;
  });
}

TEST(GsThreads, ProblemInDouble) { CheckProblem<double>(); }
TEST(GsThreads, ProblemInFloat) { CheckProblem<float>(); }

TEST(GsThreads, DensityIsTheSameOnAnyNumber) {
  constexpr Index kCount = 9000;  // more than one task
  test::DensityScene scene(kCount);
  const SplatModel before = scene.model;
  std::vector<float> pulls;
  for (Index i = 0; i < kCount; ++i) pulls.push_back(static_cast<float>(i % 1000));
  ExpectSameForAnyThreads([&] {
    scene.model = before;
    DensityOptions options;
    options.grow_pull = 200;  // more candidates than room
    options.max_gaussians = kCount + 3000;
    DensityControl<Host> control(options, 1);
    control.ResetStatistics(kCount);
    scene.Observe(control, pulls);
    test::ModelAdam adam{LearningRates()};
    std::vector<float> gradient(scene.model.data.size(), 1.0f);
    adam.Step(scene.model, gradient.data(), scene.model.num_attributes(), 1);
    test::Densify(control, scene.model, adam, 1);
    EXPECT_EQ(scene.model.count, kCount + 3000);
    gradient.assign(scene.model.data.size(), -0.5f);
    adam.Step(scene.model, gradient.data(), scene.model.num_attributes(), 1);
    return scene.model.data;
  });
}

TEST(GsThreads, TrainingOfDifferentDegreesIsTheSameOnAnyNumber) {
  const Scene scene = test::TrainingScene();
  const SplatModel start = test::WithDegrees(test::RandomModel(60, 3, 8), test::MixedDegrees(60));
  ExpectSameForAnyThreads([&] { return Refine(scene, start, ShortTraining(30, 2), {}, {}).model.data; });
}

TEST(GsThreads, TrainingOfCamerasTooIsTheSameOnAnyNumber) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = ShortTraining(50, 0);
  options.cameras.refine = CameraChoice::kAll;
  ExpectSameForAnyThreads([&] {
    const TrainResult result = Train(scene, options, {}, {});
    std::vector<double> found;
    for (const ViewUnknowns& view : result.cameras) {
      found.insert(found.end(), view.motion.quaternion, view.motion.quaternion + 4);
      found.insert(found.end(), view.color.gain.begin(), view.color.gain.end());
      found.insert(found.end(), view.lens.log_focal, view.lens.log_focal + 2);
    }
    return std::pair(result.model.data, found);
  });
}

// Large enough for many parallel tasks.
TEST(GsThreads, SumsOfViewsAreTheSameOnAnyNumber) {
  const test::SyntheticViews all(3, splat::NumAttributes(3), 20000);
  ExpectSameForAnyThreads([&] {
    SumOfViews<Host> sum;
    DensityControl<Host> density({}, 1);
    density.ResetStatistics(all.gaussians());
    sum.Begin(all.layout, 3, &density);
    std::vector<float> gradient;
    for (Index k = 0; k < 3; ++k) {
      const test::SyntheticViews::View& view = all.views[static_cast<std::size_t>(k)];
      gradient = view.gradient;
      sum.Add(k, view.pull_view(), gradient.data(), [&] { return view.cost; });
    }
    sum.Finish(gradient.data());
    gradient.insert(gradient.end(), density.pull().begin(), density.pull().end());
    return gradient;
  });
}

TEST(GsThreads, TrainingBySeveralViewsIsTheSameOnAnyNumber) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = ShortTraining(50, 0);
  options.adam.batch_size = 3;
  options.adam.iterations = 150;
  ExpectSameForAnyThreads([&] {
    const TrainResult result = Train(scene, options, {}, {});
    EXPECT_GT(result.model.count, 60) << "includes densification";
    return result.model.data;
  });
}

TEST(GsThreads, TrainingIsTheSameOnAnyNumber) {
  const Scene scene = test::TrainingScene();
  const TrainOptions options = ShortTraining(50, 2);
  ExpectSameForAnyThreads([&] {
    const TrainResult result = Train(scene, options, {}, {});
    EXPECT_GT(result.model.count, 60) << "includes densification";
    return result.model.data;
  });
}

}  // namespace
}  // namespace vesta::gs
