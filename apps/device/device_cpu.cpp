// SPDX-License-Identifier: Apache-2.0
// Builds without CUDA.
#include "apps/device/device.h"
#include "kernels/core/check.h"

namespace vesta::app {

void CheckDevice(Device device) {
  if (device == Device::kCuda) Fail(kUnavailable, "--device=cuda: this build has no CUDA; use --device=cpu");
}

gs::StageRunners StagesOf(Device device) {
  CheckDevice(device);
  return gs::HostStages();
}

Profile::Clock ProfileClock(Device /*device*/) { return ReadClocks; }

}  // namespace vesta::app
