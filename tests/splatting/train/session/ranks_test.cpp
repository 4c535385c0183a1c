// SPDX-License-Identifier: Apache-2.0
// Trainings by several ranks, emulated by threads. Label threads: runs under the thread sanitizer too.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "splatting/train/session/checkpoint.h"
#include "tests/splatting/train/is_note.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/temp_folder.h"
#include "tests/support/thread_ranks.h"
#include "tests/support/throws_error.h"

namespace vesta::gs {
namespace {

// With scoring views, and an evaluation during the training.
TrainOptions TrainingOnRanks(int iterations, int lm_iterations) {
  TrainOptions options = test::ShortTraining(iterations, lm_iterations);
  options.adam.evaluations = 2;
  options.pruning = PruningOptions();
  options.adam.batch_size = 3;
  return options;
}

// Expects the same result on all `count` ranks and returns it.
TrainResult TrainOn(int count, const Scene& scene, const TrainOptions& options,
                    const StageRunners& stages = HostStages()) {
  std::vector<TrainResult> all(static_cast<std::size_t>(count));
  vesta::test::OnThreadRanks(count, [&](Communicator& ranks) {
    TrainCallbacks callbacks;
    callbacks.ranks = &ranks;
    all[static_cast<std::size_t>(ranks.rank())] = Train(scene, options, {}, callbacks, stages);
  });
  for (const TrainResult& result : all) {
    EXPECT_EQ(result.model.data, all[0].model.data);
    EXPECT_EQ(result.history.back().test.psnr, all[0].history.back().test.psnr);
    EXPECT_EQ(result.history.back().cost, all[0].history.back().cost);
  }
  return std::move(all[0]);
}

// Options with both stages.
TrainOptions Options() { return TrainingOnRanks(60, 2); }

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
  const Scene scene = test::TrainingScene(700);
  TrainOptions options = TrainingOnRanks(60, 0);
  options.density.max_gaussians = 1000;
  const TrainResult alone = Train(scene, options, {}, {});
  EXPECT_NE(alone.model.count, 700) << "Gaussians are added and removed";
  EXPECT_EQ(TrainOn(3, scene, options).model.data, alone.model.data);
  options.adam.batch_size = 1;
  EXPECT_EQ(TrainOn(2, scene, options).model.data, Train(scene, options, {}, {}).model.data);
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

TEST(TrainingOverRanks, FindsNoCameras) {
  TrainOptions options = Options();
  for (const CameraChoice choice : {CameraChoice::kPose, CameraChoice::kAll, CameraChoice::kAuto}) {
    options.cameras.refine = choice;
    EXPECT_THAT([&] { TrainOn(2, test::TrainingScene(), options); }, ThrowsError(kUnsupported, "2"));
  }
}

// One rank's share can contain all measured views.
TEST(TrainingOverRanks, MeasuresAsManyViewsWhateverTheirNumber) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = Options();
  options.evaluated_views = 3;
  const TrainResult alone = TrainOn(1, scene, options), together = TrainOn(2, scene, options);
  for (const TrainResult* result : {&alone, &together}) {
    EXPECT_EQ(result->history.back().train.views, 3);
    EXPECT_EQ(result->history.back().test.views, 2);
    EXPECT_THAT(result->notes, testing::Contains(test::IsNote(notes::kEvaluatesSomeViews, "3", "10")));
  }
  EXPECT_EQ(together.history.back().train.psnr, alone.history.back().train.psnr);
  EXPECT_EQ(together.history.back().cost, alone.history.back().cost);
}

// Only rank 0 writes the checkpoint. All ranks must make any change for that.
void ExpectStopAndResume(const Scene& scene, const TrainOptions& options, const std::vector<int>& stops) {
  const TrainResult whole = TrainOn(1, scene, options);
  const TempFolder folder;
  const std::string path = folder / "checkpoint";
  for (const int stop : stops) {
    vesta::test::OnThreadRanks(2, [&](Communicator& ranks) {
      TrainCallbacks callbacks;
      callbacks.ranks = &ranks;
      int done = 0;
      callbacks.progress = [&](const TrainProgress& p) { done = p.iteration; };
      // Adam calls `stop` before it reports an iteration, LM after.
      const int told = options.adam.runs() ? stop - 1 : stop;
      callbacks.stop = [&] { return ranks.rank() == 1 && done >= told; };
      if (ranks.rank() == 0)
        callbacks.checkpoint = {.path = path, .every = {.iterations = 1000}, .origin = "of a test"};
      EXPECT_TRUE(Train(scene, options, {}, callbacks).stopped);
    });
    const Checkpoint checkpoint = ReadCheckpoint(path);
    EXPECT_EQ(checkpoint.run.iteration, stop);
    vesta::test::OnThreadRanks(2, [&](Communicator& ranks) {
      TrainCallbacks callbacks;
      callbacks.ranks = &ranks;
      callbacks.resume = &checkpoint;
      EXPECT_EQ(Train(scene, options, {}, callbacks).model.data, whole.model.data) << "stopped at " << stop;
    });
  }
}

TEST(TrainingOverRanks, IsStoppedAnywhereAndGoesOn) {
  std::vector<int> all(14);
  std::iota(all.begin(), all.end(), 1);
  // Three views an iteration: 15 iterations.
  ExpectStopAndResume(test::TrainingScene(), TrainingOnRanks(45, 1), all);
}

// Rank 0's clock decides.
TEST(TrainingOverRanks, EndsTogetherWhereTimeIsLimited) {
  const Scene scene = test::TrainingScene();
  for (const int lm_iterations : {0, 2}) {
    TrainOptions options = TrainingOnRanks(1000000, lm_iterations);
    options.time_limit = 0.5;
    std::vector<TrainResult> all(2);
    vesta::test::OnThreadRanks(2, [&](Communicator& ranks) {
      TrainCallbacks callbacks;
      callbacks.ranks = &ranks;
      all[static_cast<std::size_t>(ranks.rank())] =
          Train(scene, options, {.seconds = ranks.rank() == 1 ? -100.0 : 0.0}, callbacks);
    });
    EXPECT_EQ(all[0].model.data, all[1].model.data);
    EXPECT_LT(all[0].history.back().iteration, 100000);
    EXPECT_EQ(all[0].history.size(), all[1].history.size());
    EXPECT_EQ(all[0].history.back().stage, lm_iterations > 0 ? Stage::kLm : Stage::kAdam);
  }
}

TEST(TrainingOverRanks, RefusesWhatOneProcessAloneCanDo) {
  const Scene scene = test::TrainingScene();
  const auto expect_refusal = [&](const Scene& given, const TrainOptions& options, const StageRunners& stages,
                                  ErrorCode code, const char* token) {
    EXPECT_THAT([&] { TrainOn(2, given, options, stages); }, ThrowsError(code, token));
  };
  StageRunners on_gpu = HostStages();
  on_gpu.device_memory = [] { return DeviceMemoryUse{}; };
  expect_refusal(scene, Options(), on_gpu, kUnsupported, "--device=cuda");
  TrainOptions with_budget = Options();
  with_budget.memory.budget_gib = 1;
  expect_refusal(scene, with_budget, HostStages(), kUnsupported, "--memory_budget=1");
  Scene stored = scene;
  stored.photographs = std::make_shared<PhotographStore>(1e6);
  expect_refusal(stored, Options(), HostStages(), kOutOfMemory, "--photographs_mib");
}

}  // namespace
}  // namespace vesta::gs
