// SPDX-License-Identifier: Apache-2.0
// What the compiler made of each kernel that has been launched, and how often the host launched and waited.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vesta::device {

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

}  // namespace vesta::device
