// SPDX-License-Identifier: Apache-2.0
// For host code: tells whether GPU kernels can run, launches them, and lists their registers and bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "kernels/core/device_memory.h"

namespace vesta::device {

// Compiler statistics.
struct KernelStatistics {
  std::string name;  // as in error messages
  int registers = 0;
  std::size_t local_bytes = 0, shared_bytes = 0;  // per thread (arrays and spills); per block
};
// One element per launched kernel, in the order in which the kernels were first launched. Instances of one template can
// have the same name.
std::vector<KernelStatistics> KernelTable();

// Counters of one host thread since its start. A sort or a running sum counts as one launch. A call of ReadLagged
// counts as a wait if the previous copy may still be running.
struct HostWork {
  std::int64_t launches = 0, waits = 0;
};
inline HostWork& CountedHostWork() {
  thread_local HostWork work;
  return work;
}

// Called once per kernel by launch.cuh, for KernelTable.
void RegisterKernel(const char* name, const void* kernel);

// Returns an empty string if the GPU can run this program's kernels, otherwise CUDA's error message. For example, the
// program has no machine code for this GPU, or its PTX is too new for the driver.
std::string UnsupportedReason();

// The error message for a GPU that cannot run the kernels. reason: from UnsupportedReason. capability: 10 major +
// minor.
inline std::string NoCodeMessage(const std::string& gpu, int capability, const std::string& reason) {
  return gpu + " has compute capability " + std::to_string(capability / 10) + "." + std::to_string(capability % 10) +
         ", for which this program has no code; build it with CMAKE_CUDA_ARCHITECTURES=" + std::to_string(capability) +
         " (CUDA: " + reason + ")";
}

// Calls launch(), which launches a kernel and returns false if memory ran out. If it returns false, gives the pool's
// unused memory back to the driver and tries again. If this fails too, throws OutOfDeviceMemory with the kernel's name.
template <class Launch>
void LaunchOrThrow(const Launch& launch, const char* name) {
  ++CountedHostWork().launches;
  if (launch()) return;
  TrimPool();
  if (!launch()) throw OutOfDeviceMemory(std::string("not enough GPU memory to launch kernel ") + name);
}

}  // namespace vesta::device
