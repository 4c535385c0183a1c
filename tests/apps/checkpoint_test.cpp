// SPDX-License-Identifier: Apache-2.0
// Trainings that are killed and resumed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "splatting/io/splats/splat_file.h"
#include "tests/apps/refusal.h"
#include "tests/apps/tiny_scene.h"

namespace vesta::test {
namespace {

using testing::HasSubstr;

class KilledTraining : public testing::Test {
 protected:
  KilledTraining() { WriteTinyScene(scene_); }

  std::vector<std::string> Train(const std::string& out, std::vector<std::string> flags = {}) const {
    flags.insert(flags.begin(), {"train", scene_, "--out=" + out, "--iterations=4000", "--lm_iterations=3"});
    return flags;
  }
  // Leaves a checkpoint in out_.
  void TrainAndKill() const {
    Program program(Train(out_, {"--checkpoint_every=100"}));
    ASSERT_TRUE(program.WaitForOutput("adam 2000/4000")) << program.Wait().err;
    program.Signal(SIGKILL);
    ASSERT_EQ(program.Wait().status, 128 + SIGKILL);
    ASSERT_FALSE(std::filesystem::exists(out_ + "/point_cloud.ply"));
    ASSERT_TRUE(std::filesystem::exists(out_ + "/checkpoint.vesta"));
  }

  TempFolder folder_;
  const std::string scene_ = folder_ / "scene", out_ = folder_ / "out", whole_ = folder_ / "whole";
};

TEST_F(KilledTraining, GoesOnToTheSameSplat) {
  TrainAndKill();
  const ProgramOutput resumed = RunProgram({"train", "--resume=" + out_, "--profile"});
  ASSERT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_THAT(resumed.out, HasSubstr("\nphase ")) << "profile of the resumed part";
  ASSERT_EQ(RunProgram(Train(whole_)).status, 0);
  EXPECT_EQ(ReadBytes(out_ + "/point_cloud.ply"), ReadBytes(whole_ + "/point_cloud.ply"));
}

// Resumed without checkpoint flags, and killed again later.
TEST_F(KilledTraining, IsSavedAsOftenAfterItIsResumed) {
  TrainAndKill();
  const std::string first = ReadBytes(out_ + "/checkpoint.vesta");
  Program again({"train", "--resume=" + out_});
  ASSERT_TRUE(again.WaitForOutput("adam 3000/4000")) << again.Wait().err;
  again.Signal(SIGKILL);
  ASSERT_EQ(again.Wait().status, 128 + SIGKILL);
  EXPECT_NE(ReadBytes(out_ + "/checkpoint.vesta"), first);
  EXPECT_EQ(RunProgram({"train", "--resume=" + out_}).status, 0);
}

TEST_F(KilledTraining, IsSavedByCtrlCToo) {
  Program program(Train(out_, {"--checkpoint_every=1000m"}));
  ASSERT_TRUE(program.WaitForOutput("adam 2000/4000")) << program.Wait().err;
  program.Signal(SIGINT);
  const ProgramOutput stopped = program.Wait();
  EXPECT_EQ(stopped.status, 130);
  EXPECT_THAT(stopped.out, HasSubstr("; continue with `vesta train --resume " + out_ + "`\n"));
  const ProgramOutput resumed = RunProgram({"train", "--resume=" + out_, "--out=" + (folder_ / "more")});
  ASSERT_EQ(resumed.status, 0) << resumed.err;
  ASSERT_EQ(RunProgram(Train(whole_)).status, 0);
  EXPECT_EQ(ReadBytes(folder_ / "more/point_cloud.ply"), ReadBytes(whole_ + "/point_cloud.ply"));
}

TEST_F(KilledTraining, DamagedAndForeignCheckpointsAreNamedAndNothingIsLost) {
  TrainAndKill();
  const std::string file = out_ + "/checkpoint.vesta", bytes = ReadBytes(file);
  std::string flipped = bytes;
  flipped[bytes.size() / 3] = static_cast<char>(flipped[bytes.size() / 3] ^ 1);
  for (const std::string& damaged : {bytes.substr(0, bytes.size() / 2), flipped, std::string("ply\nformat ascii\n")}) {
    std::ofstream(file, std::ios::binary) << damaged;
    ExpectRefusal({"train", "--resume=" + out_}, kFailed, {file});
    EXPECT_EQ(ReadBytes(file), damaged);
  }
  std::ofstream(file, std::ios::binary) << bytes;
  EXPECT_EQ(RunProgram({"train", "--resume=" + out_}).status, 0);
}

TEST_F(KilledTraining, WhatCannotChangeIsNamed) {
  TrainAndKill();
  struct Case {
    const char* flag;
    std::vector<std::string> tokens;
  };
  for (const auto& [flag, tokens] :
       std::vector<Case>{{"--set=adam.second_moment=diagonal", {"adam.second_moment=block", "diagonal"}},
                         {"--seed=5", {"train.seed=0", "5"}},
                         {"--eps2d=0.1", {"train.eps2d=0.3", "0.1"}},
                         {"--antialias", {"train.antialias=false", "true"}},
                         {"--set=adam.batch_size=2", {"adam.batch_size=1", "2"}},
                         {"--iterations=200", {"--iterations=200"}},
                         {"--preset=paper", {"--preset=paper"}}}) {
    ExpectRefusal({"train", "--resume=" + out_, flag}, kFailed, tokens);
  }
  ExpectRefusal({"train", "--resume=" + (folder_ / "none")}, kFailed, {"none/checkpoint.vesta", "--checkpoint_every"});
  ExpectRefusal(Train(whole_, {"--checkpoint_every=often"}), kUsage, {"--checkpoint_every=often"});
  // The resumed run may run more LM iterations.
  EXPECT_EQ(RunProgram({"train", "--resume=" + out_, "--lm_iterations=5", "--set=lm.function_tolerance=0"}).status, 0);
}

TEST_F(KilledTraining, LeavesItsSnapshots) {
  const ProgramOutput output =
      RunProgram(Train(out_, {"--snapshot_every=2000", "--lm_iterations=1", "--eps2d=0.1", "--background=0.25,0.5,1"}));
  ASSERT_EQ(output.status, 0) << output.err;
  for (const char* name : {"snapshot_adam_002000.ply", "snapshot_adam_004000.ply", "snapshot_lm_000001.ply"}) {
    const gs::SplatModel snapshot = gs::ReadSplat(out_ + "/" + name);
    EXPECT_EQ(snapshot.eps2d, 0.1) << name;
    EXPECT_THAT(snapshot.background, testing::ElementsAre(0.25f, 0.5f, 1.0f)) << name;
  }
  EXPECT_EQ(RunProgram({"eval", out_ + "/snapshot_adam_002000.ply", scene_}).status, 0);
}

}  // namespace
}  // namespace vesta::test
