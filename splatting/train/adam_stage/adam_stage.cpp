// SPDX-License-Identifier: Apache-2.0
// The Adam stage for the host.
#include "splatting/train/adam_stage/adam_stage.h"

#include "kernels/gaussian_splatting/view/camera_jacobian.h"

namespace vesta::gs {

template void RunAdamStage<CpuBackend<float>>(TrainingSession& session, SplatModel& model);

}  // namespace vesta::gs
