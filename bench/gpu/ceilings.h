// SPDX-License-Identifier: Apache-2.0
// Measures the limits of this GPU: memory bandwidth and floating-point rate.
#pragma once

#include <functional>

namespace vesta::bench {

// Bytes read and written per second by a large copy within device memory.
double CopyBytesPerSecond();
// Floating-point operations per second of independent fused multiply-adds in registers; each counts as two.
double FlopsPerSecond();

// Median milliseconds of `repeats` calls, measured with CUDA events, after one untimed call. body only launches
// kernels.
double DeviceMilliseconds(int repeats, const std::function<void()>& body);

}  // namespace vesta::bench
