// What the compiler made of each kernel that has been launched.
#pragma once

#include <cstddef>
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

// Adds a kernel. launch.cuh calls it once for each.
void NoteKernel(const char* name, const void* kernel);

}  // namespace vesta::device
