// The stages of a GPU where its memory runs out on the way: the run goes on with what it has. On a device that is
// emulated.
#include "problems/gaussian_splatting/train/device_stages.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "kernels/core/device_memory.h"
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/train/checkpoint_model.h"
#include "problems/gaussian_splatting/train/evaluate_or_download.h"
#include "problems/gaussian_splatting/train/lm_steps.h"
#include "tests/problems/gaussian_splatting/cameras/bent_photograph.h"
#include "tests/problems/gaussian_splatting/cameras/perturbed_view.h"
#include "tests/problems/gaussian_splatting/train/stopped_training.h"
#include "tests/problems/gaussian_splatting/train/training_on_ranks.h"
#include "tests/problems/gaussian_splatting/train/training_scene.h"
#include "tests/support/emulated_device.h"

namespace vesta::gs {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;
using vesta::test::LimitedDeviceMemory;

constexpr int kIterations = 60;

TrainOptions AdamAlone() {
  TrainOptions options = test::ShortTraining(kIterations, 0);
  options.adam.evaluations = 4;
  return options;
}

// Trains with ample memory until `when` says of an iteration of Adam that from then on there is only what is in use.
template <class When>
TrainResult TrainUntilFull(const Scene& scene, const TrainOptions& options, const When& when) {
  const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
  TrainCallbacks callbacks;
  callbacks.progress = [&](const TrainProgress& p) {
    if (p.stage == Stage::kAdam && when(p)) vesta::test::SetDeviceMemory(device::BytesInUse());
  };
  return Train(scene, options, 0, callbacks, DeviceStages());
}

TEST(DeviceStages, AdamGoesOnWithoutTheGaussiansThatDoNotFit) {
  const Scene scene = test::TrainingScene();
  const TrainOptions options = AdamAlone();
  const TrainResult ample = Train(scene, options, 0, {}, DeviceStages());
  EXPECT_THAT(ample.notes, IsEmpty());
  // With what was before the last growth, which it kept on the GPU.
  EXPECT_NEAR(ample.memory.device_predicted_mib / ample.memory.device_peak_mib, 1.04, 0.1);
  Index before = 0;
  int last = 0;
  const TrainResult full = TrainUntilFull(scene, options, [&](const TrainProgress& p) {
    if (p.iteration == 15) before = p.gaussians;
    last = std::max(last, p.iteration);
    return p.iteration == 15;
  });
  ASSERT_GT(ample.model.count, before) << "so that memory has an effect";
  EXPECT_THAT(
      full.notes,
      ElementsAre(AllOf(StartsWith("Adam goes on from iteration "), HasSubstr("and no more: the GPU has no room")),
                  StartsWith("Adam leaves its last parameters, not their mean: the GPU has no room")));
  EXPECT_EQ(last, kIterations);
  EXPECT_EQ(full.history.back().iteration, kIterations);
  EXPECT_LE(full.model.count, before);
  EXPECT_NEAR(full.history.back().train.psnr, ample.history.back().train.psnr, 2);
}

// What was before a growth stays on the GPU where that has room beyond what was planned for, and takes nothing from it
// where it has not. To go back to it gives the same bits either way.
TEST(DeviceStages, GoesBackToWhatTheGpuKeptOrTheHost) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = AdamAlone();
  // Views without memory after the growth at iteration 20.
  const auto train_until = [&](double budget_gib) {
    TrainOptions limited = options;
    limited.memory.budget_gib = budget_gib;
    TrainCallbacks callbacks;
    bool failed = false;
    callbacks.progress = [&](const TrainProgress& p) {
      if (p.iteration == 21 && !std::exchange(failed, true)) vesta::test::FailLaunches(0, 2);
    };
    const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
    return Train(scene, limited, 0, callbacks, DeviceStages());
  };
  const TrainResult roomy = train_until(0);
  EXPECT_THAT(roomy.notes, ElementsAre(StartsWith("Adam goes on from iteration 20 with ")));
  constexpr double kMibPerGib = 1024;
  // The copy, of three vectors and the bases, is more than what is left of this.
  const double budget = 1.01 * roomy.memory.device_peak_mib / kMibPerGib * 0.85;
  const TrainResult tight = train_until(budget);
  EXPECT_THAT(tight.notes, ElementsAre(StartsWith("Adam goes on from iteration 20 with ")));
  EXPECT_LT(tight.memory.device_peak_mib, roomy.memory.device_peak_mib);
  EXPECT_LE(tight.memory.device_peak_mib, budget * kMibPerGib);
  EXPECT_EQ(tight.model.data, roomy.model.data);
}

// Who goes is judged on the host, by the model on the GPU.
TEST(DeviceStages, PrunesAsTheHostDoes) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = AdamAlone();
  options.density.enabled = false;
  options.parsimony = {.keep = 0.5, .begin = 0.5, .end = 0.7, .every = 0.1};
  options.adam.average_part = 0.8;  // there is a mean by then, which is not who is judged
  const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
  const TrainResult on_gpu = Train(scene, options, 0, {}, DeviceStages());
  const TrainResult on_host = Train(scene, options, 0, {});
  ASSERT_EQ(on_host.model.count, static_cast<Index>(scene.points.size()) / 2);
  EXPECT_EQ(on_gpu.model.count, on_host.model.count);
  EXPECT_NEAR(on_gpu.history.back().train.psnr, on_host.history.back().train.psnr, 0.3);
}

// Half of every photograph is wrecked, and does not count: both see nothing of that.
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
  const TrainResult host = Train(scene, options, 0, {}), device = Train(scene, options, 0, {}, DeviceStages());
  EXPECT_THAT(device.notes, IsEmpty());
  EXPECT_EQ(device.history.back().stage, Stage::kLm);
  EXPECT_NEAR(device.history.back().train.psnr, host.history.back().train.psnr, 1);
  for (View& view : scene.views) view.image.mask.clear();
  const TrainResult wrecked = Train(scene, options, 0, {}, DeviceStages());
  EXPECT_GT(device.history.back().train.psnr, wrecked.history.back().train.psnr + 5);
}

// Views whose cameras, exposures and lens are off.
Scene CamerasOff(Scene scene) {
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const auto role = scene.views[v].role;
    scene.views[v] = test::PerturbedView(scene.views[v], test::RandomMotion(0.5, 0.015, v));
    scene.views[v].role = role;
    for (float& value : scene.views[v].image.rgb) value *= v % 2 == 0 ? 0.9F : 1.0F;
  }
  return scene;
}
TrainOptions FindingCameras() {
  TrainOptions options = test::ShortTraining(40, 0);
  options.density.enabled = false;
  options.cameras.refine = CameraChoice::kAll;
  options.adam.coarse_part = 0.5;
  options.adam.evaluations = 1;
  return options;
}
double Distance(const splat::CameraMotion& a, const splat::CameraMotion& b) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    sum +=
        std::pow(2 * (a.quaternion[1 + k] - b.quaternion[1 + k]), 2) + std::pow(a.translation[k] - b.translation[k], 2);
  }
  return std::sqrt(sum);
}

// Cameras that are off, and photographs of which one is larger than the others, and of a lens that bends.
struct OffScene {
  SplatModel model = test::RandomModel(60, 1, 7);
  Scene scene = test::RingWithImages(model, 8, 56, 42);

  OffScene() {
    scene.views[2] = test::RingWithImages(model, 8, 128, 128).views[2];  // large enough for a coarse one
    scene = CamerasOff(std::move(scene));
    scene.views[2].image = test::Bent(scene.views[2].image, scene.views[2].camera, {0.3, 0});
    scene.views[2].bent = BentCamera{scene.views[2].camera, {.radial = {-0.1}}};
  }
};

void ExpectToBeFoundAlike(const Scene& scene, const TrainResult& device, const TrainResult& host) {
  EXPECT_THAT(device.notes, IsEmpty());
  EXPECT_NEAR(device.history.back().train.psnr, host.history.back().train.psnr, 0.1);
  EXPECT_GT(device.history.back().train.psnr, host.history.front().train.psnr + 1);
  ASSERT_EQ(device.cameras.size(), host.cameras.size());
  for (std::size_t v = 0; v < device.cameras.size(); ++v) {
    const ViewUnknowns &found = device.cameras[v], &expected = host.cameras[v];
    EXPECT_LT(Distance(found.motion, expected.motion), 0.05 * Distance(expected.motion, {}));
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(found.color.gain[c], expected.color.gain[c], 0.005);
    for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(found.lens.log_focal[k], expected.lens.log_focal[k], 0.002);
    const Camera& camera = scene.views[v + 1].camera;  // the first is for testing
    EXPECT_NEAR(CornerBend(camera, found.lens.radial), CornerBend(camera, expected.lens.radial), 0.1);
    EXPECT_EQ(CornerBend(camera, found.lens.radial) > 0.2, v + 1 == 2);
  }
}

TEST(DeviceStages, FindsCamerasAsTheHostDoes) {
  const OffScene off;
  const TrainOptions options = FindingCameras();
  const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
  ExpectToBeFoundAlike(off.scene, Refine(off.scene, off.model, options, 0, {}, DeviceStages()),
                       Refine(off.scene, off.model, options, 0, {}));
}

// By LM, at once with the splats.
TEST(DeviceStages, FindsCamerasByLmAsTheHostDoes) {
  const OffScene off;
  TrainOptions options = FindingCameras();
  options.adam.iterations = 0, options.lm.iterations = 2, options.lm.min_gain = 0, options.lm.pcg_iterations = 3;
  const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
  ExpectToBeFoundAlike(off.scene, Refine(off.scene, off.model, options, 0, {}, DeviceStages()),
                       Refine(off.scene, off.model, options, 0, {}));
}

// Poses alone, by LM, of a splat that is right.
class JointLmOnDevice : public testing::Test {
 protected:
  JointLmOnDevice() {
    options_.cameras.refine = CameraChoice::kPose;
    options_.adam.iterations = 0, options_.lm.iterations = 2, options_.lm.min_gain = 0, options_.lm.pcg_iterations = 2;
  }
  TrainResult Run(const TrainCallbacks& callbacks) const {
    return Refine(scene_, model_, options_, 0, callbacks, DeviceStages());
  }

  const LimitedDeviceMemory ample_{vesta::test::kAmpleDeviceMemory};
  const SplatModel model_ = test::RandomModel(60, 1, 7);
  const Scene scene_ = CamerasOff(test::RingWithImages(model_, 6, 40, 30));
  TrainOptions options_ = FindingCameras();
};

TEST_F(JointLmOnDevice, SolvesForCamerasAlongWhereThereIsNoRoomToEliminateThem) {
  options_.lm.iterations = 1;
  const TrainResult whole = Run({});
  EXPECT_THAT(whole.notes, IsEmpty());
  options_.memory.budget_gib = (whole.memory.device_predicted_mib - 0.2) / 1024;
  const TrainResult along = Run({});
  EXPECT_THAT(along.notes, Contains(HasSubstr("no room to eliminate")));
  EXPECT_LT(along.memory.device_peak_mib, whole.memory.device_peak_mib);
  EXPECT_NEAR(along.memory.device_predicted_mib / along.memory.device_peak_mib, 1.04, 0.1);
  EXPECT_GT(along.history.back().train.psnr, along.history.front().train.psnr + 1);
}

TEST_F(JointLmOnDevice, GoesOnFromACheckpoint) {
  const auto refine = [&](const TrainCallbacks& callbacks) { return Run(callbacks); };
  const TrainResult whole = refine({}), result = test::GoneOn(test::StoppedAt(1, refine, Stage::kLm), refine);
  EXPECT_EQ(result.model.data, whole.model.data);
  test::ExpectSameCameras(result, whole);
}

// Memory that was thought to suffice does not: what was found by the iterations that were finished is kept, cameras and
// all, wherever in the next one it ends.
TEST_F(JointLmOnDevice, EndsWithWhatItHas) {
  std::vector<int> ends;
  for (const Index room : {-1000, 100000, 200000, 300000}) {
    TrainCallbacks callbacks;
    callbacks.progress = [&](const TrainProgress& p) {
      if (p.iteration == 1) vesta::test::SetDeviceMemory(device::BytesInUse() + static_cast<std::size_t>(room));
    };
    const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
    const TrainResult result = Run(callbacks);
    const HistoryRow& last = result.history.back();
    ends.push_back(last.iteration);
    if (last.iteration < 2) {
      EXPECT_THAT(result.notes, Contains(StartsWith(fmt::format("LM ends after {} iterations: ", last.iteration))));
    }
    Scene moved = scene_;
    moved.views = MovedViews(scene_, result.cameras);
    for (std::size_t v = 0; v < moved.views.size(); ++v) moved.views[v].image = scene_.views[v].image;
    EXPECT_NEAR(Renderer(options_.background, NearPlane(scene_)).Evaluate(result.model, moved).train.psnr,
                last.train.psnr, 0.01);
  }
  EXPECT_EQ(ends.front(), 1);
  EXPECT_EQ(ends.back(), 2);
}

// A curvature is a late peak of memory. Without room for one more the training goes on, and cameras are found.
TEST(DeviceStages, OlderCurvaturesServeWhereThereIsNoRoomForNewOnes) {
  const SplatModel model = test::RandomModel(60, 1, 7);
  const Scene scene = CamerasOff(test::RingWithImages(model, 8, 56, 42));
  TrainOptions options = FindingCameras();
  TrainCallbacks callbacks;
  callbacks.progress = [](const TrainProgress& p) {
    // All views have been through, so that what else needs memory has it.
    if (p.iteration == 8) vesta::test::SetDeviceMemory(device::BytesInUse() + 100000);
  };
  const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
  const TrainResult result = Refine(scene, model, options, 0, callbacks, DeviceStages());
  EXPECT_THAT(result.notes, Contains(StartsWith("cameras are stepped by older curvatures, or stay where there is")));
  EXPECT_EQ(result.history.back().iteration, 40);
  EXPECT_GT(result.history.back().train.psnr, result.history.front().train.psnr + 1);
}

// The last that there was room for are of images of half the size.
TEST(DeviceStages, OlderCurvaturesAreOfTheSizeOfNow) {
  const SplatModel model = test::RandomModel(60, 1, 7);
  const Scene scene = CamerasOff(test::RingWithImages(model, 8, 144, 128));
  TrainOptions options = FindingCameras();
  options.cameras.refine = CameraChoice::kPose;
  options.adam.iterations = 24;
  const auto train = [&](bool is_limited) {
    TrainCallbacks callbacks;
    callbacks.progress = [&](const TrainProgress& p) {
      if (is_limited && p.iteration == 13) vesta::test::SetDeviceMemory(device::BytesInUse() + 500000);
    };
    const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
    return Refine(scene, model, options, 0, callbacks, DeviceStages());
  };
  const TrainResult whole = train(false), limited = train(true);
  EXPECT_THAT(limited.notes, Contains(StartsWith("cameras are stepped by older curvatures")));
  double off = 0, moved = 0;
  for (std::size_t v = 0; v < whole.cameras.size(); ++v) {
    const splat::CameraMotion &found = limited.cameras[v].motion, &expected = whole.cameras[v].motion;
    off += Distance(found, expected), moved += Distance(expected, {});
  }
  EXPECT_LT(off, 0.3 * moved) << "steps that are four times as long overshoot";
}

TEST(DeviceStages, AdamEndsWithItsModelWhereMemoryRunsOut) {
  // One view is larger than all before it.
  Scene scene = test::RingOfCameras(8, 24, 16, false);
  Scene large = test::RingOfCameras(8, 96, 64, false);
  scene.views.back() = large.views.back();
  test::RenderTruth(test::RandomModel(60, 1, 7), 0.05, &scene);
  TrainOptions options = AdamAlone();
  options.density.enabled = false;
  options.seed = 2;
  const TrainResult result = TrainUntilFull(scene, options, [&](const TrainProgress& p) { return p.iteration == 1; });
  ASSERT_EQ(result.notes.size(), 1u);
  EXPECT_THAT(result.notes.front(), StartsWith("Adam ends after "));
  EXPECT_THAT(result.notes.front(), HasSubstr("the GPU has no room"));
  const HistoryRow& last = result.history.back();
  EXPECT_EQ(last.stage, Stage::kAdam);
  EXPECT_GT(last.iteration, 0);
  EXPECT_LT(last.iteration, 8);
  // The model is the one that these iterations made.
  EXPECT_EQ(result.model.data, [&] {
    TrainCallbacks callbacks;
    int done = 0;
    callbacks.progress = [&](const TrainProgress& p) { done = p.iteration; };
    callbacks.stop = [&] { return done == last.iteration - 1; };
    return Train(scene, options, 0, callbacks, DeviceStages()).model.data;
  }());
}

TEST(DeviceStages, ALaunchWithoutMemoryIsTriedAgainOrEndsAdam) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = AdamAlone();
  options.density.enabled = false;
  options.adam.evaluations = 1;  // at the end: an evaluation without room is the host's
  const TrainResult ample = Train(scene, options, 0, {}, DeviceStages());
  constexpr int kInTheMidst = 700;  // some 20 an iteration
  vesta::test::FailLaunches(kInTheMidst, 1);
  const TrainResult once = Train(scene, options, 0, {}, DeviceStages());
  EXPECT_THAT(once.notes, IsEmpty());
  EXPECT_EQ(once.model.data, ample.model.data);
  vesta::test::FailLaunches(kInTheMidst, 2);
  const TrainResult twice = Train(scene, options, 0, {}, DeviceStages());
  EXPECT_THAT(twice.notes, ElementsAre(AllOf(StartsWith("Adam ends after "), HasSubstr("the threads of a kernel"))));
  EXPECT_GT(twice.history.back().iteration, 10);
}

TEST(DeviceStages, AdamRunsOnTheCpuWhereNothingFits) {
  const Scene scene = test::TrainingScene();
  const TrainOptions options = AdamAlone();
  StageRunners stages = DeviceStages();
  stages.device_memory = {};  // as if all had been thought to fit
  const LimitedDeviceMemory limited(device::BytesInUse() + 1000);
  const TrainResult result = Train(scene, options, 0, {}, stages);
  EXPECT_THAT(result.notes, ElementsAre(StartsWith("Adam runs on the CPU: the GPU has no room")));
  EXPECT_EQ(result.model.data, Train(scene, options, 0, {}).model.data);
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
  // Room for the first of it.
  const LimitedDeviceMemory limited(before + 20000);
  const Evaluation found = evaluate(), expected = session.history().Evaluate(ToKernelModel(model));
  EXPECT_EQ(downloads, 1);
  EXPECT_EQ(device::BytesInUse(), before) << "what was begun is given back";
  EXPECT_EQ(found.cost, expected.cost);
  EXPECT_EQ(found.test.ssim, expected.test.ssim);
}

TEST(DeviceStages, LmIsLeftOutWhereItDoesNotFitAfterAdam) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = test::ShortTraining(20, 1);
  options.adam.evaluations = 1;
  options.density.enabled = false;
  StageRunners stages = DeviceStages();
  const auto adam = stages.adam;
  stages.adam = [&](TrainingSession& session, SplatModel& model) {
    adam(session, model);
    vesta::test::SetDeviceMemory(device::BytesInUse() + 100000);
  };
  const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
  const TrainResult planned = Train(scene, options, 0, {}, stages);
  EXPECT_THAT(planned.lm_left_out, HasSubstr("of the GPU"));
  EXPECT_EQ(planned.history.back().iteration, 20);
  // The same found out on the way only.
  vesta::test::SetDeviceMemory(vesta::test::kAmpleDeviceMemory);
  stages.device_memory = {};
  const TrainResult found = Train(scene, options, 0, {}, stages);
  ASSERT_FALSE(found.notes.empty());
  EXPECT_THAT(found.notes.front(), StartsWith("LM goes on with one view at a time: "));
  EXPECT_THAT(found.notes.back(), StartsWith("LM ends after 0 iterations: "));
  EXPECT_EQ(found.model.data, planned.model.data);
}

// What was done before a break is not done again.
TEST(DeviceStages, LmKnowsWhatWasDoneWhereItDoesNotFitAfterABreak) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = test::ShortTraining(20, 4);
  options.adam.evaluations = 1;
  options.lm.min_gain = 0;
  options.density.enabled = false;
  const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
  StageRunners stages = DeviceStages();
  const auto train = [&](const TrainCallbacks& callbacks) { return Train(scene, options, 0, callbacks, stages); };
  const Checkpoint saved = test::StoppedAt(2, train, Stage::kLm);
  ASSERT_EQ(saved.iteration(), 2);
  stages.device_memory = {};  // by which it would be planned
  const auto lm = stages.lm;
  stages.lm = [&](TrainingSession& session, SplatModel& model, bool hold_batches) {
    vesta::test::SetDeviceMemory(device::BytesInUse() + 100000);
    return lm(session, model, hold_batches);
  };
  const TrainResult result = test::GoneOn(saved, train);
  EXPECT_THAT(result.notes, Contains(StartsWith("LM ends after 2 iterations: ")));
  EXPECT_EQ(result.model.data, ModelOfCheckpoint(saved, options).data);
}

}  // namespace
}  // namespace vesta::gs
