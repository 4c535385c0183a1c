// SPDX-License-Identifier: Apache-2.0
// A GPU emulated on the CPU. Test programs link libraries test_emulated_* instead of vesta::*_cuda. These run the
// kernels of the GPU code thread by thread (emulated_block.h). GPU memory is counted and can be limited. Each CPU
// thread has its own device. The emulation is some thousand times slower than a GPU, so scenes should have only a few
// tiles.
#pragma once

#include <cstddef>

namespace vesta::test {

// Total, bytes. Existing allocations remain.
void SetDeviceMemory(std::size_t bytes);
// More than any test needs.
inline constexpr std::size_t kAmpleDeviceMemory = std::size_t{1} << 40;

// After the next `skipped` launches, the following `attempts` fail for lack of memory.
void FailLaunches(int skipped, int attempts);
// For launch.cuh: counts an attempt. Returns false if it must fail for lack of memory.
bool LaunchFindsMemory();
// Number of times that unused memory was returned to the driver.
int NumTrims();

// While it exists, the program has no code for this type of GPU.
class WithoutDeviceCode {
 public:
  WithoutDeviceCode();
  ~WithoutDeviceCode();
  WithoutDeviceCode(const WithoutDeviceCode&) = delete;
  WithoutDeviceCode& operator=(const WithoutDeviceCode&) = delete;
};

// While it exists, the device has this much memory, bytes. The destructor sets kAmpleDeviceMemory.
class LimitedDeviceMemory {
 public:
  explicit LimitedDeviceMemory(std::size_t bytes) { SetDeviceMemory(bytes); }
  ~LimitedDeviceMemory() { SetDeviceMemory(kAmpleDeviceMemory); }
  LimitedDeviceMemory(const LimitedDeviceMemory&) = delete;
  LimitedDeviceMemory& operator=(const LimitedDeviceMemory&) = delete;
};

}  // namespace vesta::test
