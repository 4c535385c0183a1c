// SPDX-License-Identifier: Apache-2.0
// A GPU emulated on the CPU, for tests on machines without a GPU. Test programs link libraries test_emulated_* instead
// of vesta::*_cuda. These run the kernels of the GPU code thread by thread (emulated_block.h). GPU memory is counted
// and can be limited. Each CPU thread has an emulated device with its own memory. The emulation is some thousand times
// slower than a GPU, so scenes should have only a few tiles.
#pragma once

#include <cstddef>

namespace vesta::test {

// Sets the total memory of the device, bytes. Existing allocations remain.
void SetDeviceMemory(std::size_t bytes);
// More than any test needs.
inline constexpr std::size_t kAmpleDeviceMemory = std::size_t{1} << 40;

// Lets kernel launches fail: after the next `skipped` launches, the following `attempts` fail for lack of memory.
void FailLaunches(int skipped, int attempts);
// For Launch (launch.cuh): counts an attempt to launch. Returns false if it must fail for lack of memory.
bool LaunchFindsMemory();
// Number of times that unused memory was returned to the driver.
int NumTrims();

// While an object exists, the program behaves as if it had no code for this type of GPU.
class WithoutDeviceCode {
 public:
  WithoutDeviceCode();
  ~WithoutDeviceCode();
  WithoutDeviceCode(const WithoutDeviceCode&) = delete;
  WithoutDeviceCode& operator=(const WithoutDeviceCode&) = delete;
};

// While an object exists, the device has this much memory, bytes. The destructor sets kAmpleDeviceMemory.
class LimitedDeviceMemory {
 public:
  explicit LimitedDeviceMemory(std::size_t bytes) { SetDeviceMemory(bytes); }
  ~LimitedDeviceMemory() { SetDeviceMemory(kAmpleDeviceMemory); }
  LimitedDeviceMemory(const LimitedDeviceMemory&) = delete;
  LimitedDeviceMemory& operator=(const LimitedDeviceMemory&) = delete;
};

}  // namespace vesta::test
