// SPDX-License-Identifier: Apache-2.0
// Kernels of the GPU, as the host sees them: whether they can run, how they are launched, and what the compiler made of
// each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "kernels/core/device_memory.h"

namespace vesta::device {

// What the compiler made of a kernel.
struct KernelFacts {
  std::string name;  // as errors name it
  int registers = 0;
  std::size_t local_bytes = 0, shared_bytes = 0;  // of a thread (arrays and spills); of a block
};
// In the order of the first launch; kernels that share a name follow each other.
std::vector<KernelFacts> KernelTable();

// Of a thread of the host since it began: kernels that it launched, a sort or a running sum being one, and how often it
// waited for the device. A reading that lags waits where its copy may still be under way.
struct HostWork {
  std::int64_t launches = 0, waits = 0;
};
inline HostWork& CountedHostWork() {
  thread_local HostWork work;
  return work;
}

// Adds a kernel. launch.cuh calls it once for each.
void NoteKernel(const char* name, const void* kernel);

// Empty where the GPU in use can run this program's kernels, else CUDA's reason: no machine code for it, or PTX that is
// too new for the driver.
std::string WhyNoCodeRuns();

// What a user is told then, and can do. capability: 10 major + minor.
inline std::string NoCodeWords(const std::string& gpu, int capability, const std::string& reason) {
  return gpu + " has compute capability " + std::to_string(capability / 10) + "." + std::to_string(capability % 10) +
         ", for which this program has no code; build it with CMAKE_CUDA_ARCHITECTURES=" + std::to_string(capability) +
         " (CUDA: " + reason + ")";
}

// launch() launches a kernel and says whether there was memory for it. Where there was none, the pool's unused memory
// goes back to the driver and it is called once more. Throws OutOfDeviceMemory, naming the kernel, where that does not
// help either.
template <class Launch>
void LaunchOrThrow(const Launch& launch, const char* name) {
  ++CountedHostWork().launches;
  if (launch()) return;
  TrimPool();
  if (!launch()) throw OutOfDeviceMemory(std::string("the GPU has no room for the threads of a kernel: ") + name);
}

}  // namespace vesta::device
