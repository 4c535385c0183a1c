// SPDX-License-Identifier: Apache-2.0
// The Adam stage on the host.
#include "kernels/gaussian_splatting/view/camera_jacobian.h"
#include "splatting/train/adam_stage/run_adam_stage.h"

namespace vesta::gs {

template void RunAdamStage<CpuBackend<float>>(TrainingSession& session, SplatModel& model);

}  // namespace vesta::gs
