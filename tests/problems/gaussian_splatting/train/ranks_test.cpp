// Trainings by several processes, which are threads of this one. Label threads: run under the thread sanitizer too.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/adam/block_adam_formula.h"
#include "problems/gaussian_splatting/train/checkpoint.h"
#include "tests/problems/gaussian_splatting/cameras/perturbed_view.h"
#include "tests/problems/gaussian_splatting/train/training_on_ranks.h"
#include "tests/support/temp_folder.h"

namespace vesta::gs {
namespace {

using test::TrainOn;

// Both stages.
TrainOptions Options() { return test::TrainingOnRanks(60, 2); }

TEST(TrainingOverRanks, ComesToTheSameBitsForAnyNumberOfThem) {
  const Scene scene = test::TrainingScene();
  const TrainOptions options = Options();
  const TrainResult alone = TrainOn(1, scene, options);
  test::ExpectLastRowIsOf(alone, scene, options.background);
  for (const int count : {2, 3}) {
    const TrainResult together = TrainOn(count, scene, options);
    EXPECT_EQ(together.model.data, alone.model.data) << count;
    EXPECT_EQ(together.history.back().cost, alone.history.back().cost);
  }
}

TEST(TrainingOverRanks, AdamsStageIsThatOfAProcessAlone) {
  const Scene scene = test::SceneToDivide();
  TrainOptions options = test::DividedTraining(60, 0);
  const TrainResult alone = Train(scene, options, 0, {});
  EXPECT_GT(alone.model.count, kTurnChunk) << "not all are one's";
  EXPECT_NE(alone.model.count, 700) << "Gaussians come and go";
  EXPECT_EQ(TrainOn(3, scene, options).model.data, alone.model.data);
  options.adam.views_per_iteration = 1;
  EXPECT_EQ(TrainOn(2, scene, options).model.data, Train(scene, options, 0, {}).model.data);
}

TEST(TrainingOverRanks, EndsWhereTheViewsHeldOutAreGoodEnough) {
  Scene scene = test::TrainingScene();
  HoldOut(&scene.views);
  TrainOptions options = Options();
  options.target_psnr = 5;
  const TrainResult result = TrainOn(2, scene, options);
  EXPECT_GE(result.history.back().held_out.psnr, 5);
  EXPECT_LT(result.history.back().iteration, 20);
}

// A scene of whose training views as many are left, each camera turned and moved.
Scene WithCamerasOff(int trained) {
  Scene scene = test::WithCamerasOff(test::TrainingScene(), 2, 0.05);
  std::erase_if(scene.views, [&](const View& view) { return view.is_trained() && --trained < 0; });
  return scene;
}

TEST(TrainingOverRanks, CamerasMoveAlikeInAllOfThem) {
  const Scene scene = WithCamerasOff(10);
  TrainOptions options = Options();
  for (const CameraChoice choice : {CameraChoice::kPose, CameraChoice::kAuto}) {
    options.cameras.refine = choice;
    const TrainResult alone = TrainOn(1, scene, options);
    ASSERT_EQ(alone.cameras.size(), 10u);
    for (const ViewUnknowns& view : alone.cameras) EXPECT_NE(view.motion.translation[0], 0);
    const TrainResult together = TrainOn(choice == CameraChoice::kPose ? 2 : 3, scene, options);
    EXPECT_EQ(together.model.data, alone.model.data);
    test::ExpectSameCameras(together, alone);
    EXPECT_EQ(together.notes, alone.notes);
  }
}

// Exposures, and lenses that all views share: one that bends still, and is stepped by what views of all processes tell.
TEST(TrainingOverRanks, ExposuresAndLensesAreFoundAlikeByAllOfThem) {
  Scene scene = WithCamerasOff(10);
  for (View& view : scene.views) view.bent = BentCamera{view.camera, {.radial = {-0.1}}};
  for (float& value : scene.views[1].image.rgb) value *= 0.8f;
  TrainOptions options = Options();
  for (const CameraChoice choice : {CameraChoice::kPoseAndExposure, CameraChoice::kAll}) {
    options.cameras.refine = choice;
    const TrainResult alone = TrainOn(1, scene, options);
    ASSERT_EQ(alone.cameras.size(), 10u);
    const bool finds_lenses = choice == CameraChoice::kAll;
    for (const ViewUnknowns& view : alone.cameras) {
      EXPECT_NE(view.color.gain[0], 1);
      EXPECT_EQ(view.lens.log_focal[0] != 0, finds_lenses);
      EXPECT_EQ(view.lens.radial[0] != 0, finds_lenses);
    }
    const TrainResult together = TrainOn(3, scene, options);
    EXPECT_EQ(together.model.data, alone.model.data);
    test::ExpectSameCameras(together, alone);
    EXPECT_EQ(together.notes, alone.notes);
  }
}

// By LM, at once with the splats, after Adam's stage.
TEST(TrainingOverRanks, LmFindsCamerasAlikeInAllOfThem) {
  Scene scene = WithCamerasOff(10);
  for (View& view : scene.views) view.bent = BentCamera{view.camera, {.radial = {-0.1}}};
  TrainOptions options = Options();
  options.cameras.refine = CameraChoice::kAll;
  options.cameras.joint = true;
  const TrainResult alone = TrainOn(1, scene, options);
  EXPECT_EQ(alone.history.back().stage, Stage::kLm);
  TrainOptions without = options;
  without.lm.iterations = 0;
  EXPECT_GT(
      std::abs(alone.cameras[3].motion.translation[0] - TrainOn(1, scene, without).cameras[3].motion.translation[0]),
      1e-6)
      << "more than by x in float";
  const TrainResult together = TrainOn(3, scene, options);
  EXPECT_EQ(together.model.data, alone.model.data);
  test::ExpectSameCameras(together, alone);
}

// Of six views the third of four processes has one, which is held back until it is decided.
TEST(TrainingOverRanks, OneThatHasOnlyWhatIsHeldBackWaits) {
  const Scene scene = WithCamerasOff(6);
  TrainOptions options = Options();
  options.cameras.refine = CameraChoice::kAuto;
  const TrainResult alone = TrainOn(1, scene, options);
  std::vector<test::NotedPhotographs> photographs(4);
  vesta::test::OnThreadRanks(4, [&](Ranks& ranks) {
    const Scene own = photographs[static_cast<std::size_t>(ranks.rank())].Of(scene, ranks);
    TrainCallbacks callbacks;
    callbacks.ranks = &ranks;
    EXPECT_EQ(Train(own, options, 0, callbacks).model.data, alone.model.data);
  });
}

// Those that are measured are each in the share of one.
TEST(TrainingOverRanks, MeasuresAsManyViewsWhateverTheirNumber) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = Options();
  options.evaluated_views = 3;
  const TrainResult alone = TrainOn(1, scene, options), together = TrainOn(2, scene, options);
  for (const TrainResult* result : {&alone, &together}) {
    EXPECT_EQ(result->history.back().train.views, 3);
    EXPECT_EQ(result->history.back().test.views, 2);
    EXPECT_THAT(result->notes, testing::Contains(testing::HasSubstr("3 of 10 training views")));
  }
  EXPECT_EQ(together.history.back().train.psnr, alone.history.back().train.psnr);
  EXPECT_EQ(together.history.back().cost, alone.history.back().cost);
}

// The first alone has a checkpoint to write: what is changed for its sake all of them change.
void ExpectToBeStoppedAndGoOn(const Scene& scene, const TrainOptions& options, const std::vector<int>& stops) {
  const TrainResult whole = TrainOn(1, scene, options);
  const TempFolder folder;
  const std::string path = folder / "checkpoint";
  for (const int stop : stops) {
    vesta::test::OnThreadRanks(2, [&](Ranks& ranks) {
      TrainCallbacks callbacks;
      callbacks.ranks = &ranks;
      int done = 0;
      callbacks.progress = [&](const TrainProgress& p) { done = p.iteration; };
      // Adam asks before it tells of an iteration, LM after.
      const int told = options.adam.runs() ? stop - 1 : stop;
      callbacks.stop = [&] { return ranks.rank() == 1 && done >= told; };
      if (ranks.rank() == 0)
        callbacks.checkpoint = {.path = path, .every = {.iterations = 1000}, .origin = "of a test"};
      EXPECT_TRUE(Train(scene, options, 0, callbacks).stopped);
    });
    const Checkpoint checkpoint = ReadCheckpoint(path);
    EXPECT_EQ(checkpoint.run.iteration, stop);
    vesta::test::OnThreadRanks(2, [&](Ranks& ranks) {
      TrainCallbacks callbacks;
      callbacks.ranks = &ranks;
      callbacks.resume = &checkpoint;
      EXPECT_EQ(Train(scene, options, 0, callbacks).model.data, whole.model.data) << "stopped at " << stop;
    });
  }
}

TEST(TrainingOverRanks, IsStoppedAnywhereAndGoesOn) {
  std::vector<int> all(14);
  std::iota(all.begin(), all.end(), 1);
  // Of three views: 15 iterations.
  ExpectToBeStoppedAndGoOn(test::TrainingScene(), test::TrainingOnRanks(45, 1), all);
}

// The state that is saved has what either has learned of its own Gaussians.
TEST(TrainingOverRanks, IsStoppedWhereGaussiansAreDividedAndGoesOn) {
  ExpectToBeStoppedAndGoOn(test::SceneToDivide(), test::DividedTraining(45, 1), {1, 9});
}

TEST(TrainingOverRanks, IsStoppedWhereCamerasMoveAndGoesOn) {
  TrainOptions options = test::TrainingOnRanks(45, 1);
  options.cameras.refine = CameraChoice::kAll;
  ExpectToBeStoppedAndGoOn(test::TrainingScene(), options, {4, 11});
}

TEST(TrainingOverRanks, IsStoppedWhereLmFindsCamerasAndGoesOn) {
  TrainOptions options = test::TrainingOnRanks(0, 3);
  options.cameras.refine = CameraChoice::kPoseAndExposure;
  options.lm.min_gain = 0;
  ExpectToBeStoppedAndGoOn(test::TrainingScene(), options, {1, 2});
}

TEST(TrainingOverRanks, LooksAtNoPhotographOfOthers) {
  TrainOptions options = Options();
  test::ExpectOwnPhotographsDo(3, test::TrainingScene(), options);
  options.cameras.refine = CameraChoice::kAll;
  test::ExpectOwnPhotographsDo(3, test::TrainingScene(), options);
  // LM looks at them as they were given, and at those of one of two lenses unbent.
  options.cameras.joint = true;
  test::ExpectOwnPhotographsDo(2, test::SceneThroughTwoLenses(8, 48, 36), options);
}

// Some iterations look at halves. Each process makes the photographs of its own what is found of two lenses.
TEST(TrainingOverRanks, OwnPhotographsAreDeveloped) {
  TrainOptions options = test::TrainingOnRanks(15, 0);
  options.cameras.refine = CameraChoice::kAll;
  const TrainResult found = test::ExpectOwnPhotographsDo(2, test::SceneThroughTwoLenses(6, 144, 128), options);
  EXPECT_NE(found.cameras[1].color.gain[0], 1);
  // All train on each.
  const Scene scene = test::SceneThroughTwoLenses(12, 40, 30);
  options.adam.views_per_iteration = 1;
  EXPECT_EQ(TrainOn(2, scene, options).model.data, Train(scene, options, 0, {}).model.data);
}

}  // namespace
}  // namespace vesta::gs
