// Builds with CUDA.
#include "apps/device.h"
#include "kernels/core/check.h"
#include "kernels/core/device_memory.h"
#include "problems/gaussian_splatting/train/device_stages.h"

namespace vesta::app {

void CheckDevice(Device device) {
  if (device == Device::kCuda && !QueryDevice().usable) {
    Fail("--device=cuda: no GPU to use ({}); use --device=cpu", QueryDevice().name);
  }
}

gs::StageRunners StagesOf(Device device) {
  CheckDevice(device);
  return device != Device::kCpu && QueryDevice().usable ? gs::DeviceStages() : gs::HostStages();
}

}  // namespace vesta::app
