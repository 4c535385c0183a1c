// SPDX-License-Identifier: Apache-2.0
// Kernel launches that fail for lack of memory, on an emulated device.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kernels/core/cuda_backend.h"
#include "kernels/core/device_kernels.h"
#include "kernels/core/profile.h"
#include "tests/support/emulated_device.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

TEST(DeviceLaunch, IsRetriedAfterTrimmingThePool) {
  DeviceBuffer<float> ones(3000);
  CudaBackend<float> backend;
  const int trims = test::NumTrims();
  test::FailLaunches(0, 1);
  backend.Fill(1, ones);
  EXPECT_EQ(test::NumTrims(), trims + 1);
  // The second launch of a reduction fails.
  test::FailLaunches(1, 1);
  DeviceBuffer<float> many(10000);
  backend.Fill(1, many);
  EXPECT_EQ(backend.Dot(many.view(), many.view()), 10000);
  EXPECT_EQ(test::NumTrims(), trims + 2);
}

TEST(DeviceLaunch, PhasesIncludeTheWorkOfTheDevice) {
  Profile profile(ReadClocksOf<Device>);
  const std::int64_t before = device::CountedHostWork().waits;
  {
    const ProfileScope scope(&profile);
    const ScopedPhase phase("launch");
  }
  EXPECT_EQ(device::CountedHostWork().waits, before + 4) << "at the start and end of the scope and the phase";
}

TEST(DeviceLaunch, ThrowsOutOfDeviceMemoryIfTheRetryFails) {
  DeviceBuffer<float> ones(3000);
  CudaBackend<float> backend;
  test::FailLaunches(0, 2);
  try {
    backend.Fill(1, ones);
    ADD_FAILURE() << "the launch must fail without memory";
  } catch (const OutOfDeviceMemory& error) {
    EXPECT_THAT(error.what(), HasTokens("Fill"));
  }
  backend.Fill(1, ones);
  EXPECT_EQ(backend.Dot(ones.view(), ones.view()), 3000);
}

TEST(DeviceCode, MessageNamesTheArchitectureToBuildFor) {
  EXPECT_EQ(device::NoCodeMessage("NVIDIA A", 120, "no kernel image"),
            "NVIDIA A has compute capability 12.0, for which this program has no code; build it with "
            "CMAKE_CUDA_ARCHITECTURES=120 (CUDA: no kernel image)");
}

}  // namespace
}  // namespace vesta
