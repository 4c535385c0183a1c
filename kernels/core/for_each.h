// SPDX-License-Identifier: Apache-2.0
// Calls a functor for each index in a range, on the host or on a device.
#pragma once

#include "kernels/core/parallel.h"
#include "kernels/core/span.h"

namespace vesta {

template <class Space, class F>
struct ForEachIn;

template <class F>
struct ForEachIn<Host, F> {
  static void Run(Index count, Index grain, const F& f) { ParallelFor(count, grain, f); }
};

// Defined by VESTA_DEVICE_FOR_EACH (kernels/core/for_each.cuh) in the .cu file that needs F.
template <class F>
struct ForEachIn<Device, F> {
  static void Run(Index count, Index grain, const F& f);
};

// Calls f(i) for each i in [0, count), in parallel, on the host or on a device (Space). The data that f accesses must
// be in the memory of Space. F is a named functor, cheap to copy. Its operator() is VESTA_HD, and calls with different
// i must not write the same data. grain: number of indices per task on the host. On a device, ForEach does not wait for
// the calls.
template <class Space, class F>
void ForEach(Index count, Index grain, const F& f) {
  ForEachIn<Space, F>::Run(count, grain, f);
}

}  // namespace vesta
