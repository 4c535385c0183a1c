// Trainings by several processes, each with a GPU of its own: threads, each with an emulated device of its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mutex>
#include <string>
#include <vector>

#include "kernels/core/device_memory.h"
#include "problems/gaussian_splatting/train/device_stages.h"
#include "tests/problems/gaussian_splatting/train/training_on_ranks.h"
#include "tests/support/emulated_device.h"

namespace vesta::gs {
namespace {

using test::TrainOn;
using testing::HasSubstr;

TEST(DeviceRanks, TrainToTheSameBitsForAnyNumberOfThem) {
  const Scene scene = test::TrainingScene();
  const TrainOptions options = test::TrainingOnRanks(24, 2);
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
  const Scene scene = test::TrainingScene();
  TrainOptions options = test::TrainingOnRanks(24, 0);
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

// How many Gaussians there may be goes by the GPU with the least room.
TEST(DeviceRanks, PlanForTheSmallestGpu) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = test::TrainingOnRanks(6, 0);
  options.density.max_gaussians = 1 << 20;
  std::vector<std::vector<std::string>> notes(2);
  vesta::test::OnThreadRanks(2, [&](Ranks& ranks) {
    TrainCallbacks callbacks;
    callbacks.ranks = &ranks;
    if (ranks.rank() == 1) vesta::test::SetDeviceMemory(std::size_t{64} << 20);
    notes[static_cast<std::size_t>(ranks.rank())] = Train(scene, options, 0, callbacks, DeviceStages()).notes;
  });
  EXPECT_THAT(notes[0], testing::Contains(HasSubstr("the GPU has no room for more")));
  EXPECT_EQ(notes[0], notes[1]);
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
  test::ExpectOwnPhotographsDo(2, test::TrainingOnRanks(6, 1), DeviceStages());
}

}  // namespace
}  // namespace vesta::gs
