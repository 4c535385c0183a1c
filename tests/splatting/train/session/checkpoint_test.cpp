// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/session/checkpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "splatting/train/lm_stage/lm_solve.h"
#include "splatting/train/trainer.h"
#include "tests/splatting/train/stopped_training.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

using testing::HasSubstr;

constexpr int kAdam = 60, kLm = 4;

TrainOptions Options() {
  TrainOptions options = test::ShortTraining(kAdam, kLm);
  options.adam.batch_size = 3;
  options.adam.iterations = 3 * kAdam;
  options.lm.function_tolerance = 0;
  options.density.opacity_reset_every = 0.4;
  return options;
}

class Checkpoints : public testing::Test {
 protected:
  std::string Path(const std::string& name) const { return folder_ / name; }
  std::string Write(const std::string& name, const std::string& bytes) const {
    WriteBytes(Path(name), bytes);
    return Path(name);
  }
  // Trains until `stop` iterations of `stage` are done; saves a checkpoint. With `resume`, starts from the last one.
  TrainResult TrainUntil(const TrainOptions& options, Stage stage, int stop, bool resume,
                         const StageRunners& stages = HostStages()) {
    TrainCallbacks callbacks;
    bool reached = false;
    callbacks.progress = [&](const TrainProgress& p) {
      reached = reached || (p.stage == stage && p.iteration >= stop);
    };
    callbacks.stop = [&] { return reached; };
    callbacks.checkpoint = {.path = Path("checkpoint"), .every = {.iterations = 1}, .origin = "of a test"};
    Checkpoint checkpoint;
    if (resume) {
      checkpoint = ReadCheckpoint(Path("checkpoint"));
      callbacks.resume = &checkpoint;
    }
    return Train(scene_, options, {}, callbacks, stages);
  }
  // With a valid checksum.
  void Save(RunState run, const std::string& state) const {
    WriteCheckpoint(Path("checkpoint"), run,
                    [&](ArchiveWriter& archive) { archive.Bytes(state.data(), state.size()); });
  }
  // Resumes until `stop` iterations of this state's stage are done.
  auto GoingOn(const RunState& run, const std::string& state, int stop) {
    Save(run, state);
    return [this, stage = run.stage, stop] { TrainUntil(Options(), stage, stop, true); };
  }
  static auto Reading(const std::string& path) {
    return [path] { ReadCheckpoint(path); };
  }

  TempFolder folder_;
  Scene scene_ = test::TrainingScene();
};

TEST_F(Checkpoints, ATrainingGoesOnToTheSameBits) {
  const TrainResult whole = Train(scene_, Options(), {}, {});
  ASSERT_GT(whole.model.count, 60) << "includes densification";
  struct Break {
    Stage stage;
    int iteration;
  };
  // Before and after densification (every 20), an opacity reset (24), half resolution and averaging (30), and the
  // change of stage.
  const Break breaks[] = {{Stage::kAdam, 1},  {Stage::kAdam, 19}, {Stage::kAdam, 20},
                          {Stage::kAdam, 24}, {Stage::kAdam, 30}, {Stage::kAdam, 41},
                          {Stage::kAdam, 59}, {Stage::kLm, 1},    {Stage::kLm, 3}};
  for (const Break& at : breaks) {
    SCOPED_TRACE(testing::Message() << StageName(at.stage) << " " << at.iteration);
    const TrainResult part = TrainUntil(Options(), at.stage, at.iteration, false);
    EXPECT_TRUE(part.stopped);
    const Checkpoint checkpoint = ReadCheckpoint(Path("checkpoint"));
    EXPECT_EQ(checkpoint.run.origin, "of a test");
    EXPECT_EQ(checkpoint.run.stage, at.stage);
    const TrainResult rest = TrainUntil(Options(), Stage::kLm, 1000, true);
    EXPECT_EQ(rest.model.data, whole.model.data);
    EXPECT_EQ(rest.history.back().cost, whole.history.back().cost);
    EXPECT_EQ(rest.history.back().iteration, whole.history.back().iteration);
  }
}

// A model with several SH degrees, in both stages.
TEST_F(Checkpoints, OfDifferentDegreesResumeToTheSameBits) {
  const SplatModel start =
      test::WithDegrees(test::Perturbed(test::RandomModel(60, 3, 7), 0.02, 8), test::MixedDegrees(60));
  const auto refine = [&](const TrainCallbacks& callbacks) { return Refine(scene_, start, Options(), {}, callbacks); };
  const TrainResult whole = refine({});
  EXPECT_FALSE(whole.model.is_uniform());
  EXPECT_EQ(whole.model.WithBand(3), 15);
  EXPECT_LT(whole.history.back().cost, whole.history.front().cost);
  for (const auto& [stage, iteration] : {std::pair(Stage::kAdam, 10), std::pair(Stage::kLm, 2)}) {
    const TrainResult result = test::ResumeFrom(test::StoppedAt(iteration, refine, stage), refine);
    const auto rows_of_starts = [](const TrainResult& of) {
      return std::ranges::count(of.history, 0, &HistoryRow::iteration);
    };
    EXPECT_EQ(rows_of_starts(result), rows_of_starts(whole));
    EXPECT_EQ(result.model.layout(), whole.model.layout());
    EXPECT_EQ(result.model.data, whole.model.data);
  }
}

TEST_F(Checkpoints, ManyBreaksChangeNothing) {
  const TrainResult whole = Train(scene_, Options(), {}, {});
  bool resume = false;
  for (const int iteration : {5, 20, 21, 40, 58})
    TrainUntil(Options(), Stage::kAdam, iteration, std::exchange(resume, true));
  for (const int iteration : {1, 2}) TrainUntil(Options(), Stage::kLm, iteration, true);
  EXPECT_EQ(TrainUntil(Options(), Stage::kLm, 1000, true).model.data, whole.model.data);
}

TEST_F(Checkpoints, WhilePruningResumeToTheSameBits) {
  TrainOptions options = test::ShortTraining(kAdam, 0);
  options.pruning = {.keep_fraction = 0.5, .begin = 0.6, .end = 0.9, .every = 0.1};
  const TrainResult whole = Train(scene_, options, {}, {});
  for (const int iteration : {35, 36, 42, 48, 54}) {
    TrainUntil(options, Stage::kAdam, iteration, false);
    const TrainResult resumed = TrainUntil(options, Stage::kAdam, 1000, true);
    EXPECT_EQ(resumed.model.data, whole.model.data) << iteration;
    EXPECT_EQ(resumed.notes, whole.notes) << "end-of-stage notes of the stopped run are dropped";
  }
}

// The resumed run limits the Gaussians.
TEST_F(Checkpoints, ResumeWithTheCurrentLimits) {
  TrainUntil(Options(), Stage::kAdam, 10, false);
  TrainOptions fewer = Options();
  fewer.density.max_gaussians = 62;
  EXPECT_EQ(TrainUntil(fewer, Stage::kAdam, 1000, true).model.count, 62);
  TrainUntil(fewer, Stage::kAdam, 10, false);
  EXPECT_GT(TrainUntil(Options(), Stage::kAdam, 1000, true).model.count, 62);
}

TEST_F(Checkpoints, OfMoreIterationsThanAreAskedForAreRefused) {
  TrainUntil(Options(), Stage::kAdam, 30, false);
  TrainOptions fewer = Options();
  fewer.adam.iterations = 3 * 31;
  EXPECT_THAT([&] { TrainUntil(fewer, Stage::kAdam, 1000, true); }, ThrowsError(kBadArgument, "93"));
  fewer.adam.iterations = 3 * 32;
  EXPECT_EQ(TrainUntil(fewer, Stage::kAdam, 1000, true).history.back().iteration, kLm) << "LM still follows";
}

TEST_F(Checkpoints, LmGoesOnForLonger) {
  TrainOptions longer = Options();
  longer.lm.iterations = kLm + 3;
  const TrainResult whole = Train(scene_, longer, {}, {});
  TrainUntil(Options(), Stage::kLm, 2, false);
  EXPECT_EQ(TrainUntil(longer, Stage::kLm, 1000, true).model.data, whole.model.data);
}

TEST_F(Checkpoints, OfAnotherSceneAreRefused) {
  TrainUntil(Options(), Stage::kAdam, 3, false);
  scene_.views[2].camera.lens.fx *= 1.01;
  EXPECT_THAT([&] { TrainUntil(Options(), Stage::kAdam, 6, true); }, ThrowsError(kBadArgument, Path("checkpoint")));
  const std::uint64_t before = FingerprintOf(scene_);
  scene_.views[3].bent = LensCamera{scene_.views[3].camera, {.radial = {-0.1}}};
  EXPECT_NE(FingerprintOf(scene_), before) << "another lens distortion is another scene";
}

TEST_F(Checkpoints, DamageIsNamed) {
  TrainUntil(Options(), Stage::kAdam, 3, false);
  const std::string bytes = ReadBytes(Path("checkpoint"));
  EXPECT_NO_THROW(ReadCheckpoint(Path("checkpoint")));
  std::vector<std::string> damaged{"", "ply\nformat ascii 1.0\n"};
  for (const std::size_t size : {std::size_t{9}, std::size_t{14}, bytes.size() / 2, bytes.size() - 1}) {
    damaged.push_back(bytes.substr(0, size));
  }
  for (const std::size_t at : {std::size_t{20}, bytes.size() / 2, bytes.size() - 2}) {
    damaged.push_back(bytes);
    damaged.back()[at] = static_cast<char>(bytes[at] ^ 0x10);
  }
  for (const std::string& each : damaged) {
    EXPECT_THAT(Reading(Write("damaged", each)), ThrowsError(kBadFile, Path("damaged"))) << each.size();
  }
  EXPECT_THAT(Reading(Path("missing")), ThrowsError(kNotFound, Path("missing")));
}

// Damaged contents behind a valid checksum.
TEST_F(Checkpoints, ImpossibleOnesAreRefused) {
  const auto forged = [&](Stage stage, int iteration, Stage stage_of_row) {
    RunState run;
    run.stage = stage, run.iteration = iteration;
    run.history.emplace_back().stage = stage_of_row;
    WriteCheckpoint(Path("forged"), run, [](ArchiveWriter&) {});
    return Reading(Path("forged"));
  };
  constexpr auto kNoStage = static_cast<Stage>(7);
  EXPECT_NO_THROW(forged(Stage::kLm, 3, Stage::kAdam)());
  EXPECT_THAT(forged(kNoStage, 3, Stage::kAdam), ThrowsError(kBadFile, Path("forged")));
  EXPECT_THAT(forged(Stage::kLm, -1, Stage::kAdam), ThrowsError(kBadFile, Path("forged")));
  EXPECT_THAT(forged(Stage::kLm, 3, kNoStage), ThrowsError(kBadFile, Path("forged")));
}

TEST_F(Checkpoints, OfLmWithACountThatIsNotTheModelsAreRefused) {
  std::string saved;
  ArchiveWriter archive([&](std::string_view bytes) { saved += bytes; });
  std::vector<float> parameters(splat::NumAttributes(0));
  // Multiplied by 14, the last count overflows to 14.
  for (const Index count : {Index{1}, Index{-1}, Index{2}, std::numeric_limits<Index>::min() + 1}) {
    saved.clear();
    LmStageHeader header{.layout = {.count = count}, .done = 0, .units = {}};
    archive(header, parameters);
    EXPECT_EQ(ErrorOf([&] { ModelOfLmStage(saved); }).has_value(), count != 1) << count;
  }
}

// Impossible states of the Adam stage behind a valid checksum.
TEST_F(Checkpoints, OfAdamThatAreImpossibleAreRefused) {
  TrainUntil(Options(), Stage::kAdam, 30, false);
  const Checkpoint real = ReadCheckpoint(Path("checkpoint"));
  const auto going_on = [&](const std::string& state) { return GoingOn(real.run, state, 40); };
  EXPECT_NO_THROW(going_on(real.stage_state)()) << "not changed";
  // It begins with the SH degree, the number of Gaussians, and how many lack each band.
  const auto with = [&](std::size_t at, auto value) {
    std::string state = real.stage_state;
    std::memcpy(state.data() + at, &value, sizeof(value));
    return state;
  };
  constexpr std::size_t kCount = sizeof(int), kLacking = kCount + sizeof(Index), kSize = kLacking + 3 * sizeof(Index);
  Index count = 0;
  std::memcpy(&count, real.stage_state.data() + kCount, sizeof(count));
  const std::string half = real.stage_state.substr(0, real.stage_state.size() / 2);
  for (const std::string& state :
       {with(0, 7), with(0, -1), with(kCount, count + 1), with(kCount, Index{-1}), with(kCount, Index{0}),
        with(kCount, std::numeric_limits<Index>::max()), with(kLacking, Index{1}), with(kLacking, Index{-1}),
        with(kLacking + 2 * sizeof(Index), Index{1}), with(kSize, Index{1} << 60), half, std::string()}) {
    EXPECT_THAT(going_on(state), ThrowsError(kBadFile, Path("checkpoint")));
  }
}

// The same for the LM stage.
TEST_F(Checkpoints, OfLmThatAreImpossibleAreRefused) {
  TrainUntil(Options(), Stage::kLm, 2, false);
  const Checkpoint real = ReadCheckpoint(Path("checkpoint"));
  const auto going_on = [&](const std::string& state) { return GoingOn(real.run, state, 3); };
  EXPECT_NO_THROW(going_on(real.stage_state)()) << "not changed";
  const auto with_done = [&](int done) {
    LmStageHeader header;
    ArchiveReader reader(real.stage_state);
    reader(header);
    header.done = done;
    std::string state;
    ArchiveWriter archive([&](std::string_view bytes) { state += bytes; });
    archive(header);
    return state.append(reader.rest());
  };
  EXPECT_NO_THROW(going_on(with_done(2))());
  for (const std::string& state :
       {with_done(-1), with_done(3), with_done(std::numeric_limits<int>::min()), std::string(),
        real.stage_state.substr(0, 60), real.stage_state.substr(0, real.stage_state.size() - 40)}) {
    EXPECT_THAT(going_on(state), ThrowsError(kBadFile, Path("checkpoint")));
  }
  // More iterations than requested.
  Save(real.run, with_done(2));
  TrainOptions fewer = Options();
  fewer.lm.iterations = 1;
  EXPECT_GT(TrainUntil(fewer, Stage::kLm, 1000, true).model.count, 0);
}

// A training continues if its checkpoint cannot be written.
TEST_F(Checkpoints, ThatCannotBeWrittenDoNotEndTheTraining) {
  TrainCallbacks callbacks;
  callbacks.checkpoint = {.path = Path("no_folder/checkpoint"), .every = {.iterations = 20}, .origin = ""};
  const TrainResult result = Train(scene_, Options(), {}, callbacks);
  EXPECT_EQ(result.model.data, Train(scene_, Options(), {}, {}).model.data);
  ASSERT_EQ(result.notes.size(), 1u);
  EXPECT_THAT(result.notes[0], HasSubstr("no_folder/checkpoint"));
}

TEST_F(Checkpoints, SnapshotsThatCannotBeWrittenDoNotEndTheTraining) {
  TrainCallbacks callbacks;
  callbacks.snapshot_every.iterations = 20;
  callbacks.snapshot = [](Stage, int, const splat::Model<float>&) { throw Error(kOutOfMemory, "no room"); };
  const TrainResult result = Train(scene_, Options(), {}, callbacks);
  EXPECT_EQ(result.model.data, Train(scene_, Options(), {}, {}).model.data);
  EXPECT_THAT(result.notes, testing::ElementsAre("no snapshot: no room"));
}

TEST_F(Checkpoints, SnapshotsAreTheModelOnTheWay) {
  TrainCallbacks callbacks;
  std::vector<std::pair<Stage, int>> taken;
  callbacks.snapshot_every.iterations = 25;
  callbacks.snapshot = [&](Stage stage, int iteration, const splat::Model<float>& model) {
    taken.emplace_back(stage, iteration);
    EXPECT_GT(model.count, 0);
  };
  Train(scene_, Options(), {}, callbacks);
  EXPECT_THAT(taken,
              testing::ElementsAre(std::pair(Stage::kAdam, 25), std::pair(Stage::kAdam, 50), std::pair(Stage::kLm, 1),
                                   std::pair(Stage::kLm, 2), std::pair(Stage::kLm, 3), std::pair(Stage::kLm, 4)));
}

}  // namespace
}  // namespace vesta::gs
