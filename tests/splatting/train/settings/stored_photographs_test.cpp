// SPDX-License-Identifier: Apache-2.0
// Decoding photographs on demand. Label threads: runs under the thread sanitizer too.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "kernels/core/error.h"
#include "splatting/train/settings/coarse_views.h"
#include "splatting/train/settings/training_plan.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/throws_error.h"

namespace vesta::gs {
namespace {

// Large enough for views at half resolution.
Scene CoarseScene() {
  Scene scene = test::RingOfCameras(6, 144, 128, true);
  test::RenderTruth(test::RandomModel(60, 1, 7), 0.05, &scene);
  scene.views[2].image.mask.assign(144 * 128, 1);
  for (std::size_t i = 0; i < 4000; ++i) scene.views[2].image.mask[i] = 0;
  return scene;
}

// In a store that holds `room` photographs in memory.
Scene Stored(Scene scene, double room) {
  scene.photographs = std::make_shared<PhotographStore>(room * BytesOf(scene.views[2].image));
  for (View& view : scene.views) {
    const double bytes = BytesOf(view.image);
    view.stored = std::make_shared<const StoredPhotograph>(
        scene.photographs,
        PhotographSource{.decode = [image = view.image] { return image; }, .bytes = bytes, .work_bytes = 1 << 20});
    view.image = Image();
  }
  return scene;
}

TrainOptions Options() {
  TrainOptions options = test::ShortTraining(12, 0);
  options.adam.evaluations = 2;
  options.pruning = PruningOptions();  // with scoring views
  return options;
}

TEST(StoredPhotographs, TrainToTheSameBits) {
  const Scene scene = CoarseScene();
  const TrainResult expected = Train(scene, Options(), {}, {});
  for (const double room : {2.0, 5.0}) {
    const Scene stored = Stored(scene, room);
    const TrainResult found = Train(stored, Options(), {}, {});
    EXPECT_EQ(found.model.data, expected.model.data) << room;
    EXPECT_EQ(found.history.back().test.psnr, expected.history.back().test.psnr);
    EXPECT_EQ(found.history.back().cost, expected.history.back().cost);
    EXPECT_LE(stored.photographs->kept_bytes(), stored.photographs->budget_bytes());
  }
}

// A store of one photograph keeps at most one in memory: in training, evaluation and scoring.
TEST(StoredPhotographs, AreHeldOneAtATime) {
  Scene scene = CoarseScene();
  const double one = BytesOf(scene.views[2].image);
  scene.photographs = std::make_shared<PhotographStore>(one);
  std::atomic<double> most = 0;
  for (View& view : scene.views) {
    const auto decode = [&most, store = scene.photographs.get(), image = view.image] {
      most = std::max(most.load(), store->kept_bytes());
      return image;
    };
    view.stored = std::make_shared<const StoredPhotograph>(
        scene.photographs, PhotographSource{.decode = decode, .bytes = BytesOf(view.image)});
    view.image = Image();
  }
  TrainOptions options = Options();
  options.adam.evaluations = 4;
  EXPECT_EQ(Train(scene, options, {}, {}).history.size(), 4U);
  EXPECT_GT(most, 0);
  EXPECT_LE(most, one);
}

TEST(StoredPhotographs, PosesAreFoundAlongToTheSameBits) {
  const Scene scene = CoarseScene();
  TrainOptions options = Options();
  for (const CameraChoice choice : {CameraChoice::kPose, CameraChoice::kAuto}) {
    options.cameras.refine = choice;
    const TrainResult expected = Train(scene, options, {}, {}), found = Train(Stored(scene, 2), options, {}, {});
    EXPECT_EQ(found.model.data, expected.model.data);
    EXPECT_EQ(found.notes, expected.notes);
    ASSERT_EQ(found.cameras.size(), expected.cameras.size());
    for (std::size_t v = 0; v < found.cameras.size(); ++v) {
      EXPECT_EQ(found.cameras[v].motion.translation[0], expected.cameras[v].motion.translation[0]);
    }
  }
}

TEST(StoredPhotographs, HalvesAreThoseOfTheScene) {
  const Scene scene = CoarseScene(), stored = Stored(scene, 2);
  std::vector<const View*> views, stored_views;
  for (const View& view : scene.views) views.push_back(&view);
  for (const View& view : stored.views) stored_views.push_back(&view);
  const std::vector<View> expected = CoarseViews(views), found = CoarseViews(stored_views);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t v = 0; v < found.size(); ++v) {
    EXPECT_EQ(found[v].Photograph()->rgb, expected[v].image.rgb);
    EXPECT_EQ(found[v].Photograph()->mask, expected[v].image.mask);
  }
}

TEST(StoredPhotographs, MemoryIsForeseenWithTheStoreFull) {
  const Scene scene = CoarseScene(), small = Stored(scene, 2), large = Stored(scene, 6);
  TrainOptions options = Options();
  options.adam.iterations = 2;
  const double less = Train(small, options, {}, {}).memory.predicted_mib;
  const double more = Train(large, options, {}, {}).memory.predicted_mib;
  EXPECT_NEAR(more - less, 4 * BytesOf(scene.views[2].image) / (1 << 20), 1e-6);
}

TEST(StoredPhotographs, WhatNeedsThemAllIsRefused) {
  const Scene stored = Stored(CoarseScene(), 2);
  const auto training = [&](const TrainOptions& options) {
    return [&stored, options] { Train(stored, options, {}, {}); };
  };
  TrainOptions options = Options();
  options.lm.iterations = 2;
  EXPECT_THAT(training(options), ThrowsError(kOutOfMemory, "lm.iterations=2", "--photographs_mib"));
  for (const CameraChoice choice : {CameraChoice::kPoseAndExposure, CameraChoice::kAll}) {
    options = Options();
    options.cameras.refine = choice;
    EXPECT_THAT(training(options), ThrowsError(kOutOfMemory, "cameras.refine=pose", "--photographs_mib"));
  }
}

TEST(StoredPhotographs, ExposuresAreFoundWhereThoseThatAreTrainedOnFit) {
  const Scene scene = CoarseScene(), stored = Stored(scene, static_cast<int>(NumTrainingViews(scene)));
  TrainOptions options = Options();
  options.cameras.refine = CameraChoice::kAll;
  const TrainResult found = Train(stored, options, {}, {});
  EXPECT_NE(found.cameras.front().color.gain[0], 1);
  EXPECT_EQ(found.model.data, Train(scene, options, {}, {}).model.data);
}

}  // namespace
}  // namespace vesta::gs
