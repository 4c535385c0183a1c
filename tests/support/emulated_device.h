// SPDX-License-Identifier: Apache-2.0
// A GPU emulated on the host for tests. The device libraries run their kernels thread by thread (emulated_block.h).
// Memory is counted and can be limited. Programs link a library test_emulated_* instead of vesta::*_cuda. It is some
// thousand times slower than a GPU and suits scenes of a few tiles. Each host thread has its own device with its own
// memory.
#pragma once

#include <cstddef>

namespace vesta::test {

// Sets the memory of the device in bytes; existing allocations remain.
void SetDeviceMemory(std::size_t bytes);
// More than any test needs.
inline constexpr std::size_t kAmpleDeviceMemory = std::size_t{1} << 40;

// After `skipped` more launches, the next `attempts` attempts to launch fail for lack of memory.
void FailLaunches(int skipped, int attempts);
// Registers an attempt to launch; returns false if it fails for lack of memory.
bool LaunchFindsMemory();
// How often unused memory was returned to the driver.
int NumTrims();

// While it exists, the program has no code for the device.
class WithoutDeviceCode {
 public:
  WithoutDeviceCode();
  ~WithoutDeviceCode();
  WithoutDeviceCode(const WithoutDeviceCode&) = delete;
  WithoutDeviceCode& operator=(const WithoutDeviceCode&) = delete;
};

// While it exists, the device has this much memory; before and after, ample memory.
class LimitedDeviceMemory {
 public:
  explicit LimitedDeviceMemory(std::size_t bytes) { SetDeviceMemory(bytes); }
  ~LimitedDeviceMemory() { SetDeviceMemory(kAmpleDeviceMemory); }
  LimitedDeviceMemory(const LimitedDeviceMemory&) = delete;
  LimitedDeviceMemory& operator=(const LimitedDeviceMemory&) = delete;
};

}  // namespace vesta::test
