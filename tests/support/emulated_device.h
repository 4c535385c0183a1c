// SPDX-License-Identifier: Apache-2.0
// A GPU for tests, made of the host: the device libraries with their kernels run thread by thread (emulated_block.h)
// and a memory that is counted and can be made to run out. Programs link one of the libraries test_emulated_* in the
// place of vesta::*_cuda. Some thousand times slower than a GPU: for scenes of a few tiles. Each thread of the host has
// one of its own, with its own memory.
#pragma once

#include <cstddef>

namespace vesta::test {

// The memory of the device, bytes; what is allocated stays.
void SetDeviceMemory(std::size_t bytes);
// More than any test needs.
inline constexpr std::size_t kAmpleDeviceMemory = std::size_t{1} << 40;

// After `skipped` more launches, so many attempts at one find no memory.
void FailLaunches(int skipped, int attempts);
// An attempt at a launch.
bool LaunchFindsMemory();
// How often unused memory was given back to the driver.
int NumTrims();

// During its lifetime the program has no code for the device.
class WithoutDeviceCode {
 public:
  WithoutDeviceCode();
  ~WithoutDeviceCode();
  WithoutDeviceCode(const WithoutDeviceCode&) = delete;
  WithoutDeviceCode& operator=(const WithoutDeviceCode&) = delete;
};

// During its lifetime the device has that much memory, and ample memory before and after.
class LimitedDeviceMemory {
 public:
  explicit LimitedDeviceMemory(std::size_t bytes) { SetDeviceMemory(bytes); }
  ~LimitedDeviceMemory() { SetDeviceMemory(kAmpleDeviceMemory); }
  LimitedDeviceMemory(const LimitedDeviceMemory&) = delete;
  LimitedDeviceMemory& operator=(const LimitedDeviceMemory&) = delete;
};

}  // namespace vesta::test
