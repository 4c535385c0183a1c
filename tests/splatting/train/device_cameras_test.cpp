// SPDX-License-Identifier: Apache-2.0
// Camera refinement on an emulated GPU agrees with the host, and survives when memory runs out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "kernels/core/device_memory.h"
#include "splatting/cameras/unknowns/moved_view.h"
#include "splatting/evaluate/evaluation.h"
#include "splatting/train/session/stage_runners.h"
#include "splatting/train/trainer.h"
#include "tests/splatting/cameras/perturbed_view.h"
#include "tests/splatting/train/is_note.h"
#include "tests/splatting/train/stopped_training.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/emulated_device.h"

namespace vesta::gs {
namespace {

using testing::Contains;
using testing::IsEmpty;
using vesta::test::LimitedDeviceMemory;

// Perturbs cameras, exposures and lens.
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
  options.adam.half_resolution_until = 0.5;
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

// Perturbed cameras; one photograph is larger than the others.
struct OffScene {
  SplatModel model = test::RandomModel(60, 1, 7);
  Scene scene = test::RingWithImages(model, 8, 56, 42);

  OffScene() {
    scene.views[2] = test::RingWithImages(model, 8, 128, 128).views[2];  // large enough for half resolution
    scene = CamerasOff(std::move(scene));
  }
};

void ExpectToBeFoundAlike(const TrainResult& device, const TrainResult& host) {
  EXPECT_THAT(device.notes, IsEmpty());
  EXPECT_NEAR(device.history.back().train.psnr, host.history.back().train.psnr, 0.1);
  EXPECT_GT(device.history.back().train.psnr, host.history.front().train.psnr + 1);
  ASSERT_EQ(device.cameras.size(), host.cameras.size());
  for (std::size_t v = 0; v < device.cameras.size(); ++v) {
    const ViewUnknowns &found = device.cameras[v], &expected = host.cameras[v];
    EXPECT_LT(Distance(found.motion, expected.motion), 0.05 * Distance(expected.motion, {}));
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(found.color.gain[c], expected.color.gain[c], 0.005);
    for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(found.lens.log_focal[k], expected.lens.log_focal[k], 0.002);
  }
}

TEST(DeviceStages, FindsCamerasAsTheHostDoes) {
  const OffScene off;
  const TrainOptions options = FindingCameras();
  const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
  ExpectToBeFoundAlike(Refine(off.scene, off.model, options, {}, {}, DeviceStages()),
                       Refine(off.scene, off.model, options, {}, {}));
}

// LM finds cameras jointly with Gaussians.
TEST(DeviceStages, FindsCamerasByLmAsTheHostDoes) {
  const OffScene off;
  TrainOptions options = FindingCameras();
  options.cameras.refine = CameraChoice::kPoseAndExposure;
  options.adam.iterations = 0, options.lm.iterations = 2, options.lm.function_tolerance = 0,
  options.lm.pcg_iterations = 3;
  const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
  ExpectToBeFoundAlike(Refine(off.scene, off.model, options, {}, {}, DeviceStages()),
                       Refine(off.scene, off.model, options, {}, {}));
}

// LM of camera poses, from the true splat.
class JointLmOnDevice : public testing::Test {
 protected:
  JointLmOnDevice() {
    options_.cameras.refine = CameraChoice::kPose;
    options_.adam.iterations = 0, options_.lm.iterations = 2, options_.lm.function_tolerance = 0,
    options_.lm.pcg_iterations = 2;
  }
  TrainResult Run(const TrainCallbacks& callbacks) const {
    return Refine(scene_, model_, options_, {}, callbacks, DeviceStages());
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
  EXPECT_THAT(along.notes, Contains(test::IsNote(notes::kLmEliminatesNothing)));
  EXPECT_LT(along.memory.device_peak_mib, whole.memory.device_peak_mib);
  EXPECT_NEAR(along.memory.device_predicted_mib / along.memory.device_peak_mib, 1.04, 0.1);
  EXPECT_GT(along.history.back().train.psnr, along.history.front().train.psnr + 1);
}

TEST_F(JointLmOnDevice, GoesOnFromACheckpoint) {
  const auto refine = [&](const TrainCallbacks& callbacks) { return Run(callbacks); };
  const TrainResult whole = refine({}), result = test::ResumeFrom(test::StoppedAt(1, refine, Stage::kLm), refine);
  EXPECT_EQ(result.model.data, whole.model.data);
  ASSERT_EQ(result.cameras.size(), whole.cameras.size());
  for (std::size_t v = 0; v < whole.cameras.size(); ++v) {
    EXPECT_EQ(Distance(result.cameras[v].motion, whole.cameras[v].motion), 0);
  }
}

// Memory runs out although the plan expected it to suffice. The result of the finished iterations is kept, including
// cameras, wherever in the next iteration this happens.
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
      EXPECT_THAT(result.notes, Contains(test::IsNote(notes::kLmEnds, std::to_string(last.iteration))));
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

// Camera curvatures need the most memory, late in the run. Without it the training continues with old curvatures and
// still finds the cameras.
TEST(DeviceStages, OlderCurvaturesServeWhereThereIsNoRoomForNewOnes) {
  const SplatModel model = test::RandomModel(60, 1, 7);
  const Scene scene = CamerasOff(test::RingWithImages(model, 8, 56, 42));
  TrainOptions options = FindingCameras();
  TrainCallbacks callbacks;
  callbacks.progress = [](const TrainProgress& p) {
    // After one pass over the views, all other memory is allocated.
    if (p.iteration == 8) vesta::test::SetDeviceMemory(device::BytesInUse() + 100000);
  };
  const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
  const TrainResult result = Refine(scene, model, options, {}, callbacks, DeviceStages());
  EXPECT_THAT(result.notes, Contains(test::IsNote(notes::kCamerasByOlderCurvatures)));
  EXPECT_EQ(result.history.back().iteration, 40);
  EXPECT_GT(result.history.back().train.psnr, result.history.front().train.psnr + 1);
}

// The last curvatures are of half-resolution images; they are rescaled.
TEST(DeviceStages, OlderCurvaturesAreOfTheSizeOfNow) {
  const SplatModel model = test::RandomModel(60, 1, 7);
  const Scene scene = CamerasOff(test::RingWithImages(model, 8, 112, 96));
  TrainOptions options = FindingCameras();
  options.cameras.refine = CameraChoice::kPose;
  options.adam.iterations = 24;
  const auto train = [&](bool is_limited) {
    TrainCallbacks callbacks;
    callbacks.progress = [&](const TrainProgress& p) {
      if (is_limited && p.iteration == 13) vesta::test::SetDeviceMemory(device::BytesInUse() + 500000);
    };
    const LimitedDeviceMemory ample(vesta::test::kAmpleDeviceMemory);
    return Refine(scene, model, options, {}, callbacks, DeviceStages());
  };
  const TrainResult whole = train(false), limited = train(true);
  EXPECT_THAT(limited.notes, Contains(test::IsNote(notes::kCamerasByOlderCurvatures)));
  double off = 0, moved = 0;
  for (std::size_t v = 0; v < whole.cameras.size(); ++v) {
    const splat::CameraMotion &found = limited.cameras[v].motion, &expected = whole.cameras[v].motion;
    off += Distance(found, expected), moved += Distance(expected, {});
  }
  EXPECT_LT(off, 0.3 * moved) << "without rescaling, steps are four times too long";
}

}  // namespace
}  // namespace vesta::gs
