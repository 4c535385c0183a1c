// SPDX-License-Identifier: Apache-2.0
// A function of an index, run for each of them where its data lie: one call for all memory spaces.
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

// Defined where nvcc compiles F: by VESTA_DEVICE_FOR_EACH (kernels/core/for_each.cuh).
template <class F>
struct ForEachIn<Device, F> {
  static void Run(Index count, Index grain, const F& f);
};

// f(i) for each i in [0, count), in parallel. F is a named functor that is cheap to copy, its operator() is VESTA_HD,
// and calls for different i do not touch each other's data. grain: on the host this many indices make one task. On a
// device the call does not wait for the result.
template <class Space, class F>
void ForEach(Index count, Index grain, const F& f) {
  ForEachIn<Space, F>::Run(count, grain, f);
}

}  // namespace vesta
