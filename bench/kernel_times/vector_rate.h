// SPDX-License-Identifier: Apache-2.0
// Vector multiply-adds per second of this CPU, from which docs/performance.md derives lower bounds of kernel times.
#pragma once

#include "kernels/core/cpu_dispatch.h"

namespace vesta::bench {

// Full-width fused multiply-adds of floats per nanosecond on one thread: the best of a few runs of some milliseconds.
double VectorOperationsPerNanosecond(Isa isa);

}  // namespace vesta::bench
