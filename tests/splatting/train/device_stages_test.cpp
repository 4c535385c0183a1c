// SPDX-License-Identifier: Apache-2.0
// Training continues when memory of an emulated GPU runs out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "kernels/core/device_memory.h"
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/train/lm_stage/lm_solve.h"
#include "splatting/train/session/session.h"
#include "splatting/train/session/stage_runners.h"
#include "splatting/train/trainer.h"
#include "tests/splatting/train/is_note.h"
#include "tests/splatting/train/stopped_training.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/emulated_device.h"

namespace vesta::gs {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using vesta::test::LimitedDeviceMemory;

constexpr int kIterations = 60;

TrainOptions AdamAlone() {
  TrainOptions options = test::ShortTraining(kIterations, 0);
  options.adam.evaluations = 4;
  return options;
}

// The device has no free memory from the first Adam iteration on for which `when` is true.
template <class When>
TrainResult TrainUntilFull(const Scene& scene, const TrainOptions& options, const When& when) {
  const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
  TrainCallbacks callbacks;
  callbacks.progress = [&](const TrainProgress& p) {
    if (p.stage == Stage::kAdam && when(p)) vesta::test::SetDeviceMemory(device::BytesInUse());
  };
  return Train(scene, options, {}, callbacks, DeviceStages());
}

TEST(DeviceStages, AdamGoesOnWithoutTheGaussiansThatDoNotFit) {
  const Scene scene = test::TrainingScene();
  const TrainOptions options = AdamAlone();
  const TrainResult ample = Train(scene, options, {}, {}, DeviceStages());
  EXPECT_THAT(ample.notes, IsEmpty());
  // Includes the state before the last growth, which is on the GPU.
  EXPECT_NEAR(ample.memory.device_predicted_mib / ample.memory.device_peak_mib, 1.04, 0.1);
  Index before = 0;
  int last = 0;
  const TrainResult full = TrainUntilFull(scene, options, [&](const TrainProgress& p) {
    if (p.iteration == 15) before = p.gaussians;
    last = std::max(last, p.iteration);
    return p.iteration == 15;
  });
  ASSERT_GT(ample.model.count, before) << "the memory limit must have an effect";
  EXPECT_THAT(full.notes, ElementsAre(test::IsNote(notes::kAdamGoesBack), test::IsNote(notes::kAdamWithoutMean)));
  EXPECT_EQ(last, kIterations);
  EXPECT_EQ(full.history.back().iteration, kIterations);
  EXPECT_LE(full.model.count, before);
  EXPECT_NEAR(full.history.back().train.psnr, ample.history.back().train.psnr, 2);
}

// The state before densification stays on the GPU if there is memory beyond the plan, otherwise on the host. Rolling
// back gives the same bits.
TEST(DeviceStages, GoesBackToWhatTheGpuKeptOrTheHost) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = AdamAlone();
  options.density.grow_pull = 0;  // all Gaussians that a view shows, up to the limit
  // Two launches fail after the densification at iteration 20.
  const auto train_until = [&](double budget_gib) {
    TrainOptions limited = options;
    limited.memory.budget_gib = budget_gib;
    TrainCallbacks callbacks;
    bool failed = false;
    callbacks.progress = [&](const TrainProgress& p) {
      if (p.iteration == 21 && !std::exchange(failed, true)) vesta::test::FailLaunches(0, 2);
    };
    const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
    return Train(scene, limited, {}, callbacks, DeviceStages());
  };
  const TrainResult roomy = train_until(0);
  EXPECT_THAT(roomy.notes, ElementsAre(test::IsNote(notes::kAdamGoesBack, "20")));
  constexpr double kMibPerGib = 1024;
  // Without space for the copy of three vectors and the bases.
  const double budget = 1.01 * roomy.memory.device_peak_mib / kMibPerGib * 0.85;
  const TrainResult tight = train_until(budget);
  EXPECT_THAT(tight.notes, ElementsAre(test::IsNote(notes::kAdamGoesBack, "20")));
  EXPECT_LT(tight.memory.device_peak_mib, roomy.memory.device_peak_mib);
  EXPECT_LE(tight.memory.device_peak_mib, budget * kMibPerGib);
  EXPECT_EQ(tight.model.data, roomy.model.data);
}

// The host scores the Gaussians of the model on the GPU.
TEST(DeviceStages, PrunesAsTheHostDoes) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = AdamAlone();
  options.density.enabled = false;
  options.pruning = {.keep_fraction = 0.5, .begin = 0.5, .end = 0.7, .every = 0.1};
  options.adam.averaging_fraction = 0.8;  // it has begun by then; scores use the model itself
  const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
  const TrainResult on_gpu = Train(scene, options, {}, {}, DeviceStages());
  const TrainResult on_host = Train(scene, options, {}, {});
  ASSERT_EQ(on_host.model.count, static_cast<Index>(scene.points.size()) / 2);
  EXPECT_EQ(on_gpu.model.count, on_host.model.count);
  EXPECT_NEAR(on_gpu.history.back().train.psnr, on_host.history.back().train.psnr, 0.3);
}

// Half of every photograph is corrupted and masked out.
TEST(DeviceStages, MasksHoldAsOnTheHost) {
  Scene scene = test::TrainingScene();
  for (View& view : scene.views) {
    for (int i = 0; i < view.image.width * view.image.height; ++i) {
      const bool counts = i % view.image.width < view.image.width / 2;
      view.image.mask.push_back(counts ? 1 : 0);
      for (int c = 0; c < 3 && !counts; ++c) view.image.plane(c)[i] = static_cast<float>((5 * i + c) % 11) / 10;
    }
  }
  TrainOptions options = test::ShortTraining(kIterations, 2);
  options.adam.evaluations = 4;
  const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
  const TrainResult host = Train(scene, options, {}, {}), device = Train(scene, options, {}, {}, DeviceStages());
  EXPECT_THAT(device.notes, IsEmpty());
  EXPECT_EQ(device.history.back().stage, Stage::kLm);
  EXPECT_NEAR(device.history.back().train.psnr, host.history.back().train.psnr, 1);
  for (View& view : scene.views) view.image.mask.clear();
  const TrainResult wrecked = Train(scene, options, {}, {}, DeviceStages());
  EXPECT_GT(device.history.back().train.psnr, wrecked.history.back().train.psnr + 5);
}

TEST(DeviceStages, AdamEndsWithItsModelWhereMemoryRunsOut) {
  // The last view is larger than all others.
  Scene scene = test::RingOfCameras(8, 24, 16, false);
  Scene large = test::RingOfCameras(8, 96, 64, false);
  scene.views.back() = large.views.back();
  test::RenderTruth(test::RandomModel(60, 1, 7), 0.05, &scene);
  TrainOptions options = AdamAlone();
  options.density.enabled = false;
  options.seed = 2;
  const TrainResult result = TrainUntilFull(scene, options, [&](const TrainProgress& p) { return p.iteration == 1; });
  ASSERT_EQ(result.notes.size(), 1u);
  EXPECT_THAT(result.notes.front(), test::IsNote(notes::kAdamEnds));
  const HistoryRow& last = result.history.back();
  EXPECT_EQ(last.stage, Stage::kAdam);
  EXPECT_GT(last.iteration, 0);
  EXPECT_LT(last.iteration, 8);
  // By exactly these iterations.
  EXPECT_EQ(result.model.data, [&] {
    TrainCallbacks callbacks;
    int done = 0;
    callbacks.progress = [&](const TrainProgress& p) { done = p.iteration; };
    callbacks.stop = [&] { return done == last.iteration - 1; };
    return Train(scene, options, {}, callbacks, DeviceStages()).model.data;
  }());
}

TEST(DeviceStages, ALaunchWithoutMemoryIsTriedAgainOrEndsAdam) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = AdamAlone();
  options.density.enabled = false;
  options.adam.evaluations = 1;  // at the end: the host takes over an evaluation that does not fit
  const TrainResult ample = Train(scene, options, {}, {}, DeviceStages());
  constexpr int kInTheMidst = 700;  // about 20 launches an iteration
  vesta::test::FailLaunches(kInTheMidst, 1);
  const TrainResult once = Train(scene, options, {}, {}, DeviceStages());
  EXPECT_THAT(once.notes, IsEmpty());
  EXPECT_EQ(once.model.data, ample.model.data);
  vesta::test::FailLaunches(kInTheMidst, 2);
  const TrainResult twice = Train(scene, options, {}, {}, DeviceStages());
  EXPECT_THAT(twice.notes, ElementsAre(test::IsNote(notes::kAdamEnds)));
  EXPECT_GT(twice.history.back().iteration, 10);
}

TEST(DeviceStages, AdamRunsOnTheCpuWhereNothingFits) {
  const Scene scene = test::TrainingScene();
  const TrainOptions options = AdamAlone();
  StageRunners stages = DeviceStages();
  stages.device_memory = {};  // the plan then assumes that all fits
  const LimitedDeviceMemory limited(device::BytesInUse() + 1000);
  const TrainResult result = Train(scene, options, {}, {}, stages);
  EXPECT_THAT(result.notes, ElementsAre(test::IsNote(notes::kAdamOnCpu)));
  EXPECT_EQ(result.model.data, Train(scene, options, {}, {}).model.data);
}

TEST(DeviceStages, EvaluationWithoutRoomIsTheHosts) {
  const Scene scene = test::TrainingScene();
  const TrainOptions options;
  const TrainCallbacks callbacks;
  TrainingSession session(scene, options, 0, callbacks);
  const SplatModel model = test::RandomModel(30, 1, 4);
  const std::vector<TargetView<CudaBackend<float>>> targets =
      MakeTargets<CudaBackend<float>>(session.training_views(), NearPlane(session.scene()));
  DeviceBuffer<float> x;
  x.CopyFrom(HostSpan<const float>(model.data.data(), static_cast<Index>(model.data.size())));
  const splat::Model<float> on_device{x.data(), model.count, 1, 1};
  int downloads = 0;
  const auto on_host = [&] {
    ++downloads;
    return ToKernelModel(model);
  };
  const auto evaluate = [&] {
    splat::DeviceViewWorkspace workspace;
    return EvaluateOrDownload<CudaBackend<float>>(
        session, targets, [&] { return on_device; }, workspace, on_host);
  };
  evaluate();
  EXPECT_EQ(downloads, 0);
  const std::size_t before = device::BytesInUse();
  // For a part of the evaluation.
  const LimitedDeviceMemory limited(before + 20000);
  const Evaluation found = evaluate(), expected = session.history().Evaluate(ToKernelModel(model));
  EXPECT_EQ(downloads, 1);
  EXPECT_EQ(device::BytesInUse(), before) << "the partial allocations are freed";
  EXPECT_EQ(found.cost, expected.cost);
  EXPECT_EQ(found.test.ssim, expected.test.ssim);
}

TEST(DeviceStages, LmIsLeftOutWhereItDoesNotFitAfterAdam) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = test::ShortTraining(20, 1);
  options.adam.evaluations = 1;
  options.lm.jacobian = JacobianKind::kCachedViews;
  options.density.enabled = false;
  StageRunners stages = DeviceStages();
  const auto adam = stages.adam;
  stages.adam = [&](TrainingSession& session, SplatModel& model) {
    adam(session, model);
    vesta::test::SetDeviceMemory(device::BytesInUse() + 100000);
  };
  const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
  const TrainResult planned = Train(scene, options, {}, {}, stages);
  EXPECT_THAT(planned.lm_left_out, HasSubstr("of the GPU"));
  EXPECT_EQ(planned.history.back().iteration, 20);
  // LM finds out when it allocates.
  vesta::test::SetDeviceMemory(vesta::test::kAmpleDeviceMemory);
  stages.device_memory = {};
  const TrainResult found = Train(scene, options, {}, {}, stages);
  ASSERT_FALSE(found.notes.empty());
  EXPECT_THAT(found.notes.front(), test::IsNote(notes::kLmByOneView));
  EXPECT_THAT(found.notes.back(), test::IsNote(notes::kLmEnds, "0"));
  EXPECT_EQ(found.model.data, planned.model.data);
}

// LM iterations before a checkpoint are not repeated.
TEST(DeviceStages, LmKnowsWhatWasDoneWhereItDoesNotFitAfterABreak) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = test::ShortTraining(20, 4);
  options.adam.evaluations = 1;
  options.lm.function_tolerance = 0;
  options.density.enabled = false;
  const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
  StageRunners stages = DeviceStages();
  const auto train = [&](const TrainCallbacks& callbacks) { return Train(scene, options, {}, callbacks, stages); };
  const Checkpoint saved = test::StoppedAt(2, train, Stage::kLm);
  ASSERT_EQ(saved.iteration(), 2);
  stages.device_memory = {};  // no estimate, so the plan assumes that LM fits
  const auto lm = stages.lm;
  stages.lm = [&](TrainingSession& session, SplatModel& model) {
    vesta::test::SetDeviceMemory(device::BytesInUse() + 100000);
    return lm(session, model);
  };
  const TrainResult result = test::ResumeFrom(saved, train);
  EXPECT_THAT(result.notes, Contains(test::IsNote(notes::kLmEnds, "2")));
  EXPECT_EQ(result.model.data, ModelOfCheckpoint(saved, options).data);
}

}  // namespace
}  // namespace vesta::gs
