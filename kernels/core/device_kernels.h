// SPDX-License-Identifier: Apache-2.0
// GPU kernels as the host sees them: whether they can run, how they are launched, and the registers and memory that the
// compiler gave each of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "kernels/core/device_memory.h"

namespace vesta::device {

// Compiler statistics of one kernel.
struct KernelStatistics {
  std::string name;  // as in error messages
  int registers = 0;
  std::size_t local_bytes = 0, shared_bytes = 0;  // per thread (arrays and spills); per block
};
// In the order of the first launch. Kernels with the same name are listed together.
std::vector<KernelStatistics> KernelTable();

// Counters of one host thread since its start: launched kernels, and waits for the device. A sort or a running sum
// counts as one launch. ReadLagged counts as a wait if its previous copy may still be running.
struct HostWork {
  std::int64_t launches = 0, waits = 0;
};
inline HostWork& CountedHostWork() {
  thread_local HostWork work;
  return work;
}

// Registers a kernel for KernelTable. launch.cuh calls it once per kernel.
void RegisterKernel(const char* name, const void* kernel);

// Returns an empty string if the GPU in use can run this program's kernels. Otherwise returns CUDA's reason: no machine
// code for it, or PTX too new for the driver.
std::string UnsupportedReason();

// The error message for that case, with the fix. capability: 10 major + minor.
inline std::string NoCodeMessage(const std::string& gpu, int capability, const std::string& reason) {
  return gpu + " has compute capability " + std::to_string(capability / 10) + "." + std::to_string(capability % 10) +
         ", for which this program has no code; build it with CMAKE_CUDA_ARCHITECTURES=" + std::to_string(capability) +
         " (CUDA: " + reason + ")";
}

// Calls launch(), which launches a kernel and returns false if memory ran out. In that case the pool's unused memory is
// returned to the driver and launch() is tried again. If that fails too, throws OutOfDeviceMemory with the kernel's
// name.
template <class Launch>
void LaunchOrThrow(const Launch& launch, const char* name) {
  ++CountedHostWork().launches;
  if (launch()) return;
  TrimPool();
  if (!launch()) throw OutOfDeviceMemory(std::string("not enough GPU memory to launch kernel ") + name);
}

}  // namespace vesta::device
