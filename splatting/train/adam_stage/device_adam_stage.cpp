// SPDX-License-Identifier: Apache-2.0
// The Adam stage on a GPU.
#include "kernels/core/device_sort.h"
#include "kernels/gaussian_splatting/device/device_splat_view.h"
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "splatting/adam/device_adam_steps.h"
#include "splatting/cameras/derivatives/view_columns.inl"
#include "splatting/cameras/derivatives/view_curvature.inl"
#include "splatting/train/adam_stage/adam_stage.h"

namespace vesta::gs {

template void RunAdamStage<CudaBackend<float>>(TrainingSession& session, SplatModel& model);

}  // namespace vesta::gs
