// SPDX-License-Identifier: Apache-2.0
// The flag --device of a program with CUDA, on an emulated device.
#include "apps/device/device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kernels/core/check.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/emulated_device.h"
#include "tests/support/throws_error.h"

namespace vesta::app {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

TEST(DeviceFlag, AutoTakesTheGpuThatCanRunThis) {
  EXPECT_EQ(StagesOf(Device::kAuto).device, "cuda");
  EXPECT_EQ(StagesOf(Device::kCpu).device, "cpu");
  EXPECT_THAT(StagesOf(Device::kCpu).note, IsEmpty());
}

TEST(DeviceFlag, AutoSaysWhyAGpuWithoutCodeIsNotUsed) {
  const test::WithoutDeviceCode without;
  const gs::StageRunners stages = StagesOf(Device::kAuto);
  EXPECT_EQ(stages.device, "cpu");
  const gs::TrainResult result = gs::Train(gs::test::TrainingScene(), gs::test::ShortTraining(2, 0), {}, {}, stages);
  EXPECT_THAT(result.notes, ElementsAre(AllOf(StartsWith("on the CPU: "), HasSubstr("CMAKE_CUDA_ARCHITECTURES=75"))));
  EXPECT_THAT(StagesOf(Device::kCpu).note, IsEmpty()) << "requested explicitly";
}

TEST(DeviceFlag, CudaWithoutCodeIsAnError) {
  const test::WithoutDeviceCode without;
  EXPECT_THAT([] { StagesOf(Device::kCuda); },
              ThrowsError(kUnavailable, "--device=cuda", "CMAKE_CUDA_ARCHITECTURES=75", "--device=cpu"));
}

}  // namespace
}  // namespace vesta::app
