// SPDX-License-Identifier: Apache-2.0
// The limits of this GPU, measured.
#pragma once

#include <functional>

namespace vesta::bench {

// Bytes read and written a second by a large copy on the device.
double CopyBytesPerSecond();
// Floating-point operations a second of independent fused multiply-adds in registers, two each.
double FlopsPerSecond();

// Median milliseconds of `repeats` calls by events of the device, after one that is not counted. body only launches.
double DeviceMilliseconds(int repeats, const std::function<void()>& body);

}  // namespace vesta::bench
