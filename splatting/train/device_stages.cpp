// SPDX-License-Identifier: Apache-2.0
// CUDA instantiations of the training stages.
#include "kernels/core/check.h"
#include "kernels/core/device_sort.h"
#include "kernels/gaussian_splatting/device/device_splat_view.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "splatting/adam/device_adam_steps.h"
#include "splatting/cameras/derivatives/view_columns.inl"
#include "splatting/train/adam_stage/adam_stage.h"
#include "splatting/train/lm_stage/lm_stage.h"
#include "splatting/train/session/stage_runners.h"

namespace vesta::gs {

StageRunners DeviceStages() {
  const DeviceInfo& device = QueryDevice();
  if (!device.usable) Fail(kUnavailable, "--device=cuda: no GPU to use ({}); choose --device=cpu", device.name);
  device::ResetPeak();
  const auto memory = [] {
    return DeviceMemoryUse{.free_bytes = static_cast<double>(device::FreeBytes()),
                           .peak_bytes = static_cast<double>(device::PeakBytes())};
  };
  return {.device = "cuda",
          .adam = RunAdamStage<CudaBackend<float>>,
          .lm = RunLmStage<CudaBackend<float>>,
          .device_memory = memory};
}

}  // namespace vesta::gs
