// SPDX-License-Identifier: Apache-2.0
// Measures how many vector multiply-adds per second this CPU can do. docs/performance.md derives lower bounds of kernel
// times from this rate.
#pragma once

#include "kernels/core/cpu_dispatch.h"

namespace vesta::bench {

// Returns fused multiply-adds of float vectors per nanosecond on one thread, each with the full vector width of the
// instruction set. The best of a few runs of some milliseconds.
double VectorOperationsPerNanosecond(Isa isa);

}  // namespace vesta::bench
