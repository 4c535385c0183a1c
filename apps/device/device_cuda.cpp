// SPDX-License-Identifier: Apache-2.0
// Builds with CUDA.
#include "apps/device/device.h"
#include "kernels/core/check.h"
#include "kernels/core/device_memory.h"
#include "kernels/ranks/communicator.h"
#include "splatting/train/session/stage_runners.h"

namespace vesta::app {

void CheckDevice(Device device) {
  if (device == Device::kCuda && !QueryDevice().usable) {
    Fail(kUnavailable, "--device=cuda: no GPU to use ({}); use --device=cpu", QueryDevice().name);
  }
}

gs::StageRunners StagesOf(Device device) {
  CheckDevice(device);
  const bool may_use = device == Device::kCuda || (device == Device::kAuto && NumStartedRanks() == 1);
  if (may_use && QueryDevice().usable) return gs::DeviceStages();
  gs::StageRunners stages = gs::HostStages();
  // A user with a GPU expects its use, so report the reason.
  if (device == Device::kAuto && QueryDevice().present) stages.note = "on the CPU: " + QueryDevice().name;
  return stages;
}

Profile::Clock ProfileClock(Device device) {
  return StagesOf(device).device_memory ? ReadClocksOf<vesta::Device> : ReadClocks;
}

}  // namespace vesta::app
