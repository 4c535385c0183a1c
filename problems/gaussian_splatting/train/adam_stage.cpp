// The Adam stage on the host.
#include "kernels/gaussian_splatting/lens_jacobian.h"
#include "kernels/gaussian_splatting/pose_jacobian.h"
#include "problems/gaussian_splatting/train/run_adam_stage.h"

namespace vesta::gs {

template void RunAdamStage<CpuBackend<float>>(TrainingSession& session, SplatModel& model);

}  // namespace vesta::gs
