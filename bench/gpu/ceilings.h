// SPDX-License-Identifier: Apache-2.0
// Measures this GPU's memory bandwidth and floating-point rate (ceilings).
#pragma once

#include <functional>

namespace vesta::bench {

// Bytes per second that a large copy in GPU memory reads and writes, together.
double CopyBytesPerSecond();
// Independent fused multiply-adds in registers per second, each counted as two.
double FlopsPerSecond();

// Median GPU time of `repeats` calls of body in milliseconds, by CUDA events, after an untimed call. body launches
// kernels and must not wait for them.
double DeviceMilliseconds(int repeats, const std::function<void()>& body);

}  // namespace vesta::bench
