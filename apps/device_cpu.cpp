// Builds without CUDA.
#include "apps/device.h"
#include "apps/flags.h"
#include "kernels/core/check.h"

namespace vesta::app {

void CheckDeviceFlag() {
  if (FLAGS_device == "cuda") Fail("--device=cuda: this build has no CUDA; use --device=cpu");
}

gs::StageRunners StagesFromFlag() {
  CheckDeviceFlag();
  return gs::HostStages();
}

}  // namespace vesta::app
