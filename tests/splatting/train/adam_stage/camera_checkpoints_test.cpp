// SPDX-License-Identifier: Apache-2.0
// Checkpoints of trainings with refined cameras, changed as no training could have written them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "splatting/train/adam_stage/trained_model.h"
#include "splatting/train/session/checkpoint.h"
#include "tests/splatting/train/stopped_training.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

class CheckpointsOfCameras : public testing::Test {
 protected:
  using State = AdamStageState<CpuBackend<float>>;
  using Change = std::function<void(StageCamerasState&)>;

  test::TrainBy Training(CameraChoice choice) const {
    TrainOptions options = test::ShortTraining(40, 0);
    options.cameras.refine = choice;
    options.density.enabled = false;
    return [this, options](const TrainCallbacks& callbacks) { return Train(scene_, options, {}, callbacks); };
  }
  // Resumes from the checkpoint after `change`. Returns the error, if any.
  static std::optional<Error> ErrorFrom(const test::TrainBy& stopped, int after, const test::TrainBy& train,
                                        const Change& change = {}) {
    Checkpoint checkpoint = test::StoppedAt(after, stopped);
    checkpoint.path = "saved";
    if (change) {
      const TrainOptions options;
      State state{{SplatModel(),
                   Adam<CpuBackend<float>>(options.lr, options.adam.second_moment),
                   DensityControl<Host>(options.density, 1),
                   {},
                   1},
                  ViewOrder(1, options.seed)};
      ArchiveReader reader(checkpoint.stage_state);
      reader(state);
      change(state.cameras);
      checkpoint.stage_state.clear();
      ArchiveWriter writer([&](std::string_view bytes) { checkpoint.stage_state += bytes; });
      writer(state);
    }
    return ErrorOf([&] { test::ResumeFrom(checkpoint, train); });
  }
  static void ExpectBadFile(const std::optional<Error>& error) {
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code(), kBadFile) << error->what();
    EXPECT_THAT(error->what(), HasTokens("saved"));
  }
  void ExpectRefused(CameraChoice choice, int after, const Change& change) const {
    ExpectBadFile(ErrorFrom(Training(choice), after, Training(choice), change));
  }

  Scene scene_ = test::TrainingScene();
};

TEST_F(CheckpointsOfCameras, AreTakenAsTheyWere) {
  for (const CameraChoice choice : {CameraChoice::kPose, CameraChoice::kAll, CameraChoice::kAuto}) {
    EXPECT_FALSE(ErrorFrom(Training(choice), 20, Training(choice), [](StageCamerasState&) {}));
  }
}

TEST_F(CheckpointsOfCameras, OfOtherUnknownsAreRefused) {
  for (const auto& [before, after] :
       {std::pair(CameraChoice::kPose, CameraChoice::kAll), std::pair(CameraChoice::kAll, CameraChoice::kPose),
        std::pair(CameraChoice::kPose, CameraChoice::kPoseAndExposure)}) {
    ExpectBadFile(ErrorFrom(Training(before), 20, Training(after)));
  }
}

TEST_F(CheckpointsOfCameras, ThatAreImpossibleAreRefused) {
  using S = StageCamerasState;
  ExpectRefused(CameraChoice::kAll, 20, [](S& state) { state.views[3].curvature.resize(36); });
  ExpectRefused(CameraChoice::kPose, 20, [](S& state) { state.views[3].curvature.resize(4); });
  ExpectRefused(CameraChoice::kPose, 20, [](S& state) { state.views[3].age = -1; });
  ExpectRefused(CameraChoice::kPose, 20, [](S& state) { state.views.resize(3); });
  ExpectRefused(CameraChoice::kPose, 20, [](S& state) { state.views.resize(300); });
  ExpectRefused(CameraChoice::kPose, 20, [](S& state) { state.lenses.resize(1, {.views = 100}); });
  ExpectRefused(CameraChoice::kAll, 20, [](S& state) { state.lenses.resize(9, {.views = 100}); });
  ExpectRefused(CameraChoice::kPose, 20, [](S& state) { state.chosen = CameraChoice::kPose; });
  ExpectRefused(CameraChoice::kAuto, 20, [](S& state) { state.chosen = CameraChoice::kAll; });
  ExpectRefused(CameraChoice::kAuto, 2, [](S& state) { state.chosen = CameraChoice{77}; });
}

}  // namespace
}  // namespace vesta::gs
