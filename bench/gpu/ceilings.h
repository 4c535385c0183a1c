// SPDX-License-Identifier: Apache-2.0
// Measures the limits (ceilings) of this GPU: memory bandwidth and floating-point rate.
#pragma once

#include <functional>

namespace vesta::bench {

// Bytes per second that a large copy within GPU memory reads and writes, added together.
double CopyBytesPerSecond();
// Floating-point operations per second of independent fused multiply-adds in registers; each counts as two.
double FlopsPerSecond();

// Returns the median GPU time of `repeats` calls of body in milliseconds, measured with CUDA events, after one call
// that is not timed. body launches kernels and must not wait for them.
double DeviceMilliseconds(int repeats, const std::function<void()>& body);

}  // namespace vesta::bench
