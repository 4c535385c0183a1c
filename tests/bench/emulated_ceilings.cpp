// SPDX-License-Identifier: Apache-2.0
// bench/gpu/ceilings.h for an emulated device: no limits, and the host's clock.
#include "bench/gpu/ceilings.h"
#include "bench/report.h"

namespace vesta::bench {

double CopyBytesPerSecond() { return 1e9; }
double FlopsPerSecond() { return 1e9; }
double DeviceMilliseconds(int repeats, const std::function<void()>& body) { return MedianMilliseconds(repeats, body); }

}  // namespace vesta::bench
