// SPDX-License-Identifier: Apache-2.0
// What a launch does where the GPU has no memory for it: a kernel may need some for the stacks of its threads.
#pragma once

#include <string>

#include "kernels/core/device_kernels.h"
#include "kernels/core/device_memory.h"

namespace vesta::device {

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
