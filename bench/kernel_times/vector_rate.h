// SPDX-License-Identifier: Apache-2.0
// Measures the rate of vector multiply-adds of this CPU, the unit of the lower bounds in docs/performance.md.
#pragma once

#include "kernels/core/cpu_dispatch.h"

namespace vesta::bench {

// Fused multiply-adds of whole float vectors per nanosecond on one thread, with the vector width of the instruction
// set. The best of a few runs of some milliseconds.
double VectorOperationsPerNanosecond(Isa isa);

}  // namespace vesta::bench
