// SPDX-License-Identifier: Apache-2.0
// Compiles functors for ForEach on a device (kernels/core/for_each.h).
#pragma once

#include "kernels/core/for_each.h"
#include "kernels/core/launch.cuh"

// Use it in a .cu file in namespace vesta, once per functor F. name: the kernel's name in reports.
#define VESTA_DEVICE_FOR_EACH(F, name)                                             \
  template <>                                                                      \
  void ForEachIn<Device, F>::Run(Index count, Index /*grain*/, const F& functor) { \
    device::ForEach(count, functor, name);                                         \
  }
