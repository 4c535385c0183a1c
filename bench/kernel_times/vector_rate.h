// SPDX-License-Identifier: Apache-2.0
// The rate at which this CPU multiplies and adds vectors: the unit of the floors of docs/performance.md.
#pragma once

#include "kernels/core/cpu_dispatch.h"

namespace vesta::bench {

// Fused multiply-adds of whole float vectors a nanosecond on one thread, with the instruction set's own width; the
// best of a few runs of some milliseconds.
double VectorOperationsPerNanosecond(Isa isa);

}  // namespace vesta::bench
