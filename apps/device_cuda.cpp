// Builds with CUDA.
#include "apps/device.h"
#include "apps/flags.h"
#include "kernels/core/check.h"
#include "kernels/core/device_memory.h"
#include "problems/gaussian_splatting/train/device_stages.h"

namespace vesta::app {

void CheckDeviceFlag() {
  if (FLAGS_device == "cuda" && !QueryDevice().usable) {
    Fail("--device=cuda: no GPU to use ({}); use --device=cpu", QueryDevice().name);
  }
}

gs::StageRunners StagesFromFlag() {
  CheckDeviceFlag();
  return FLAGS_device != "cpu" && QueryDevice().usable ? gs::DeviceStages() : gs::HostStages();
}

}  // namespace vesta::app
