// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "splatting/train/session/checkpoint.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

Checkpoint InLm() {
  Checkpoint checkpoint;
  checkpoint.path = "some/checkpoint";
  checkpoint.run.stage = Stage::kLm, checkpoint.run.iteration = 3;
  checkpoint.run.seconds = 20, checkpoint.run.eval_seconds = 5;
  checkpoint.stage_state = "state";
  return checkpoint;
}

TEST(SavedStage, OfNoneATrainingBeginsAnew) {
  SavedStage saved(nullptr);
  EXPECT_EQ(saved.first_stage(), Stage::kAdam);
  EXPECT_EQ(saved.first_iteration(), 0);
  EXPECT_EQ(saved.seconds(), 0);
  EXPECT_EQ(saved.eval_seconds(), 0);
  EXPECT_FALSE(saved.Take(Stage::kAdam));
}

TEST(SavedStage, IsTakenByItsStageOnce) {
  const Checkpoint checkpoint = InLm();
  SavedStage saved(&checkpoint);
  EXPECT_EQ(saved.first_stage(), Stage::kLm);
  EXPECT_EQ(saved.first_iteration(), 3);
  EXPECT_EQ(saved.seconds(), 20);
  EXPECT_EQ(saved.eval_seconds(), 5);
  EXPECT_FALSE(saved.Take(Stage::kAdam));
  EXPECT_EQ(saved.Take(Stage::kLm), "state");
  EXPECT_FALSE(saved.Take(Stage::kLm));
  saved.GiveBack("state");
  EXPECT_EQ(saved.state(), "state");
  EXPECT_EQ(saved.Take(Stage::kLm), "state");
}

// The checkpoint is not blamed for lack of memory or failures of other ranks.
TEST(SavedStage, RefusesWhatCannotBeReadByName) {
  const Checkpoint checkpoint = InLm();
  const SavedStage saved(&checkpoint);
  EXPECT_EQ(saved.Validate([] { return 7; }), 7);
  EXPECT_THAT([&] { saved.Validate([]() -> int { throw Error(kBadFile, "cut short"); }); },
              ThrowsError(kBadFile, "some/checkpoint"));
  EXPECT_THAT([&] { saved.Refuse(); }, ThrowsError(kBadFile, "some/checkpoint"));
  EXPECT_THROW(saved.Validate([]() -> int { throw OutOfDeviceMemory("full"); }), OutOfDeviceMemory);
  EXPECT_THROW(saved.Validate([]() -> int { throw OtherRankFailed("gone"); }), OtherRankFailed);
}

}  // namespace
}  // namespace vesta::gs
