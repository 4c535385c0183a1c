// SPDX-License-Identifier: Apache-2.0
// Watching or pausing a training does not change its result.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/train/session/session.h"
#include "splatting/train/trainer.h"
#include "tests/splatting/train/stopped_training.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

class Watch : public testing::Test {
 protected:
  static TrainOptions Options() {
    TrainOptions options = test::ShortTraining(60, 3);
    options.lm.function_tolerance = 0;
    options.density.opacity_reset_every = 0.4;
    return options;
  }
  // Requests a checkpoint and the model after this iteration, and pauses there briefly.
  TrainCallbacks AsksAt(Stage stage, int iteration) {
    TrainCallbacks callbacks;
    callbacks.checkpoint.path = path_;
    callbacks.checkpoint.origin = "of a test";
    callbacks.progress = [=, this](const TrainProgress& p) {
      is_there_ = p.stage == stage && p.iteration == iteration;
      if (is_there_) wanted_ = true, waits_ = 3;
    };
    callbacks.watch.wants_model = [this] { return is_there_; };
    callbacks.watch.show = [this](const splat::Model<float>& model, const std::vector<ViewUnknowns>& cameras) {
      shown_.push_back(CopyOf(model)), cameras_ = cameras;
    };
    callbacks.watch.wants_checkpoint = [this] { return std::exchange(wanted_, false); };
    callbacks.watch.saved = [this](int at, const std::string& error) { saved_.emplace_back(at, error); };
    callbacks.watch.waits = [this] { return is_there_ && waits_-- > 0; };
    return callbacks;
  }

  std::vector<float> ResumeFrom(const Checkpoint& checkpoint, const TrainOptions& options) const {
    return test::ResumeFrom(checkpoint, [&](const TrainCallbacks& c) { return Train(scene_, options, {}, c); })
        .model.data;
  }

  Scene scene_ = test::TrainingScene();
  TempFolder folder_;
  std::string path_ = folder_ / "checkpoint";
  bool is_there_ = false, wanted_ = false;
  int waits_ = 0;
  std::vector<SplatModel> shown_;
  std::vector<ViewUnknowns> cameras_;
  std::vector<std::pair<int, std::string>> saved_;
};

TEST_F(Watch, ChangesNoBitAndSavesWhatGoesOnToTheSameBits) {
  const TrainOptions options = Options();
  const TrainResult alone = Train(scene_, options, {}, {});
  for (const auto& [stage, iteration] : {std::pair(Stage::kAdam, 40), std::pair(Stage::kLm, 2)}) {
    shown_.clear(), saved_.clear();
    const TrainResult watched = Train(scene_, options, {}, AsksAt(stage, iteration));
    EXPECT_EQ(watched.model.data, alone.model.data);
    ASSERT_EQ(shown_.size(), 1u) << "the model does not change during a pause";
    ASSERT_EQ(saved_.size(), 1u);
    EXPECT_EQ(saved_[0], std::pair(iteration, std::string()));

    const Checkpoint checkpoint = ReadCheckpoint(path_);
    EXPECT_EQ(checkpoint.run.stage, stage);
    EXPECT_EQ(ModelOfCheckpoint(checkpoint, options).data, shown_[0].data);
    EXPECT_EQ(ResumeFrom(checkpoint, options), alone.model.data);
  }
}

// A requested checkpoint is saved when the training stops, even without intervals.
TEST_F(Watch, SavesWhereTheTrainingStops) {
  const TrainOptions options = Options();
  const TrainResult alone = Train(scene_, options, {}, {});
  constexpr int kStop = 40;
  TrainCallbacks callbacks = AsksAt(Stage::kAdam, 1000);
  int done = 0;
  callbacks.stop = [&] { return ++done >= kStop; };
  callbacks.watch.wants_checkpoint = [&] { return done == kStop; };
  EXPECT_TRUE(Train(scene_, options, {}, callbacks).stopped);
  ASSERT_EQ(saved_.size(), 1u);
  EXPECT_EQ(saved_[0].first, kStop);
  EXPECT_EQ(ResumeFrom(ReadCheckpoint(path_), options), alone.model.data);
}

TEST_F(Watch, SavesNothingUnasked) {
  TrainCallbacks callbacks = AsksAt(Stage::kAdam, 1000);
  int left = 30;
  callbacks.stop = [&] { return --left == 0; };
  EXPECT_TRUE(Train(scene_, Options(), {}, callbacks).stopped);
  EXPECT_TRUE(saved_.empty());
  EXPECT_TRUE(shown_.empty());
  EXPECT_NE(::access(path_.c_str(), F_OK), 0);
}

TEST_F(Watch, TellsWhyNothingIsSaved) {
  path_ = folder_ / "no such folder/checkpoint";
  const TrainResult result = Train(scene_, Options(), {}, AsksAt(Stage::kAdam, 10));
  ASSERT_EQ(saved_.size(), 1u);
  EXPECT_NE(saved_[0].second.find("no such folder"), std::string::npos) << saved_[0].second;
  EXPECT_FALSE(result.stopped) << "the training continues";
}

TEST_F(Watch, PauseIsNoTimeOfTheTraining) {
  TrainCallbacks callbacks;
  int waits = 4;
  callbacks.watch.waits = [&] {
    ::usleep(100000);
    return --waits > 0;
  };
  TrainOptions options;
  options.time_limit = 1000;
  TrainingSession session(scene_, options, 5, callbacks);
  const double before = session.clock().Total();
  session.interim().ServeViewer(Stage::kAdam, 1, {}, {});
  EXPECT_EQ(waits, 0);
  EXPECT_LT(session.clock().Total() - before, 0.4);
  EXPECT_EQ(session.EvalSeconds(), 0);
}

// Work during a pause is not training time, also in the checkpoint.
TEST_F(Watch, WhatIsDoneInAPauseIsNoTimeOfTheTraining) {
  TrainCallbacks callbacks;
  callbacks.checkpoint.path = path_;
  int waits = 4;
  callbacks.watch.waits = [&] { return --waits > 0; };
  callbacks.watch.wants_checkpoint = [&] { return true; };
  TrainingSession session(scene_, TrainOptions(), 5, callbacks);
  const auto slow = [](ArchiveWriter&) { ::usleep(100000); };
  session.interim().ServeViewer(Stage::kAdam, 1, {}, slow);
  EXPECT_LT(session.clock().Total(), 5.1);
  EXPECT_LT(ReadCheckpoint(path_).run.seconds, 5.1);
}

// The cameras of the checkpoint.
TEST_F(Watch, IsShownTheCamerasToo) {
  TrainOptions options = Options();
  options.lm.iterations = 0;
  Train(scene_, options, {}, AsksAt(Stage::kAdam, 40));
  EXPECT_TRUE(cameras_.empty()) << "cameras are not optimised";
  options.cameras.refine = CameraChoice::kPose;
  const TrainResult result = Train(scene_, options, {}, AsksAt(Stage::kAdam, 40));
  ASSERT_EQ(cameras_.size(), result.cameras.size());
  const std::vector<ViewUnknowns> saved = ReadCheckpoint(path_).run.cameras;
  ASSERT_EQ(saved.size(), cameras_.size());
  bool has_moved = false;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    EXPECT_TRUE(std::ranges::equal(cameras_[i].motion.translation, saved[i].motion.translation));
    has_moved = has_moved || cameras_[i].motion.translation[0] != 0;
  }
  EXPECT_TRUE(has_moved);
}

// A damaged checkpoint.
TEST_F(Watch, ShowsNoModelOfABrokenState) {
  Train(scene_, Options(), {}, AsksAt(Stage::kAdam, 40));
  Checkpoint checkpoint = ReadCheckpoint(path_);
  EXPECT_TRUE(IsCheckpoint(path_));
  EXPECT_FALSE(IsCheckpoint(folder_ / "none"));
  checkpoint.stage_state.resize(checkpoint.stage_state.size() / 2);
  EXPECT_THAT([&] { ModelOfCheckpoint(checkpoint, Options()); }, ThrowsError(kBadFile, path_));
}

}  // namespace
}  // namespace vesta::gs
