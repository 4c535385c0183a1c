// Trainings by several processes, each with a GPU of its own: threads, each with an emulated device of its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mutex>
#include <string>
#include <vector>

#include "kernels/core/device_memory.h"
#include "problems/gaussian_splatting/train/checkpoint.h"
#include "problems/gaussian_splatting/train/device_stages.h"
#include "tests/problems/gaussian_splatting/train/training_on_ranks.h"
#include "tests/support/emulated_device.h"
#include "tests/support/temp_folder.h"

namespace vesta::gs {
namespace {

using test::TrainOn;
using testing::HasSubstr;

TEST(DeviceRanks, TrainToTheSameBitsForAnyNumberOfThem) {
  const Scene scene = test::TrainingScene();
  const TrainOptions options = test::TrainingOnRanks(18, 1);
  const TrainResult alone = TrainOn(1, scene, options, DeviceStages());
  EXPECT_GT(alone.history.back().stage, Stage::kAdam);
  for (const int count : {2, 3}) {
    EXPECT_EQ(TrainOn(count, scene, options, DeviceStages()).model.data, alone.model.data) << count;
  }
  // As the host does.
  const TrainResult host = TrainOn(2, scene, options, HostStages());
  EXPECT_NEAR(alone.history.back().test.psnr, host.history.back().test.psnr, 0.05);
  EXPECT_NEAR(alone.history.back().cost, host.history.back().cost, 0.02 * host.history.back().cost);
}

TEST(DeviceRanks, AdamsStageIsThatOfAGpuAlone) {
  const Scene scene = test::SceneToDivide();
  TrainOptions options = test::DividedTraining(24, 0);
  EXPECT_EQ(TrainOn(2, scene, options, DeviceStages()).model.data,
            Train(scene, options, 0, {}, DeviceStages()).model.data);
}

// All know of it, since one that went on with fewer Gaussians would train another model than the others.
TEST(DeviceRanks, EndTogetherWhereAGpuHasNoRoom) {
  const Scene scene = test::TrainingScene();
  const TrainOptions options = test::TrainingOnRanks(24, 0);
  std::mutex mutex;
  std::vector<std::string> words(2);
  const auto train = [&](Ranks& ranks) {
    TrainCallbacks callbacks;
    callbacks.ranks = &ranks;
    callbacks.progress = [&](const TrainProgress& p) {
      if (ranks.rank() == 1 && p.iteration == 5) vesta::test::SetDeviceMemory(device::BytesInUse());
    };
    try {
      Train(scene, options, 0, callbacks, DeviceStages());
    } catch (const Error& error) {
      const std::lock_guard lock(mutex);
      words[static_cast<std::size_t>(ranks.rank())] = error.what();
      throw;
    }
  };
  EXPECT_THROW(vesta::test::OnThreadRanks(2, train), Error);
  EXPECT_THAT(words[1], HasSubstr("the GPU has no room"));
  EXPECT_THAT(words[0], HasSubstr(words[1]));
}

// Of each of two processes what it says of a training whose GPUs have so much memory free, MiB.
std::vector<std::vector<std::string>> NotesOfTwo(double first, double second, bool is_one_gpu) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = test::TrainingOnRanks(3, 0);
  options.density.max_gaussians = 1 << 24;
  std::vector<std::vector<std::string>> notes(2);
  vesta::test::OnThreadRanks(2, [&](Ranks& ranks) {
    TrainCallbacks callbacks;
    callbacks.ranks = &ranks;
    StageRunners stages = DeviceStages();
    stages.device_memory = [bytes = (ranks.rank() == 0 ? first : second) * (1 << 20)] {
      return DeviceMemoryUse{.free_bytes = bytes, .peak_bytes = 0, .pooled_bytes = 0};
    };
    if (is_one_gpu) stages.gpu_id = "of both";
    notes[static_cast<std::size_t>(ranks.rank())] = Train(scene, options, 0, callbacks, stages).notes;
  });
  return notes;
}

// How many Gaussians there may be goes by the GPU with the least room, and by an equal part of one for two.
TEST(DeviceRanks, PlanForTheSmallestGpu) {
  const auto alike = NotesOfTwo(64, 64, false);
  EXPECT_THAT(alike[0], testing::ElementsAre(HasSubstr("the GPU has no room for more")));
  EXPECT_EQ(alike[0], alike[1]);
  for (const auto& notes : NotesOfTwo(200, 64, false)) EXPECT_EQ(notes, alike[0]);
  for (const auto& notes : NotesOfTwo(128, 128, true)) EXPECT_EQ(notes, alike[0]);
  EXPECT_NE(NotesOfTwo(128, 128, false)[0], alike[0]);
}

// What Adam has made is not lost (TrainCallbacks::before_lm), and no empty model is handed out: neither by several nor
// by one that was started as if it were several.
TEST(DeviceRanks, LmEndsWhereAGpuHasNoRoom) {
  const Scene scene = test::TrainingScene();
  const TrainOptions options = test::TrainingOnRanks(6, 3);
  for (const int count : {1, 2}) {
    Index saved = 0;
    const auto train = [&](Ranks& ranks) {
      TrainCallbacks callbacks;
      callbacks.ranks = &ranks;
      if (ranks.rank() == 0) callbacks.before_lm = [&](const SplatModel& model) { saved = model.count; };
      callbacks.progress = [&](const TrainProgress& p) {
        if (ranks.rank() == count - 1 && p.stage == Stage::kLm) vesta::test::SetDeviceMemory(device::BytesInUse());
      };
      Train(scene, options, 0, callbacks, DeviceStages());
    };
    EXPECT_THAT([&] { vesta::test::OnThreadRanks(count, train); },
                testing::ThrowsMessage<Error>(HasSubstr("the GPU has no room")));
    EXPECT_GT(saved, 0) << count;
  }
}

// Of either stage, by a GPU alone or by several: a state is the same wherever it was saved.
TEST(DeviceRanks, GoOnFromACheckpoint) {
  const Scene scene = test::SceneToDivide();
  const TrainOptions options = test::DividedTraining(24, 2);  // of three views: 8 iterations
  const TrainResult whole = TrainOn(2, scene, options, DeviceStages());
  const TempFolder folder;
  const std::string path = folder / "checkpoint";
  struct Break {
    Stage stage;
    int iteration, ranks;
  };
  for (const Break& at : {Break{Stage::kAdam, 5, 1}, Break{Stage::kAdam, 6, 3}, Break{Stage::kLm, 1, 2}}) {
    vesta::test::OnThreadRanks(at.ranks, [&](Ranks& ranks) {
      TrainCallbacks callbacks;
      callbacks.ranks = &ranks;
      bool reached = false;
      callbacks.progress = [&](const TrainProgress& p) {
        reached = reached || (p.stage == at.stage && p.iteration >= at.iteration);
      };
      callbacks.stop = [&] { return reached; };
      if (ranks.rank() == 0) callbacks.checkpoint = {.path = path, .every = {.iterations = 1}, .origin = "of a test"};
      EXPECT_TRUE(Train(scene, options, 0, callbacks, DeviceStages()).stopped);
    });
    const Checkpoint checkpoint = ReadCheckpoint(path);
    vesta::test::OnThreadRanks(2, [&](Ranks& ranks) {
      TrainCallbacks callbacks;
      callbacks.ranks = &ranks;
      callbacks.resume = &checkpoint;
      EXPECT_EQ(Train(scene, options, 0, callbacks, DeviceStages()).model.data, whole.model.data)
          << StageName(at.stage) << ", saved by " << at.ranks;
    });
  }
}

TEST(DeviceRanks, RefuseToTrainOnDifferentKinds) {
  const Scene scene = test::TrainingScene();
  const TrainOptions options = test::TrainingOnRanks(3, 0);
  const auto train = [&](Ranks& ranks) {
    TrainCallbacks callbacks;
    callbacks.ranks = &ranks;
    Train(scene, options, 0, callbacks, ranks.rank() == 0 ? DeviceStages() : HostStages());
  };
  try {
    vesta::test::OnThreadRanks(2, train);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("process 1 would train on cpu, process 0 on emulated; say --device=cpu"));
  }
}

// Those of others are not even copied to the GPU.
TEST(DeviceRanks, LookAtNoPhotographOfOthers) {
  test::ExpectOwnPhotographsDo(2, test::TrainingScene(), test::TrainingOnRanks(6, 1), DeviceStages());
}

}  // namespace
}  // namespace vesta::gs
