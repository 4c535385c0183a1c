// The Adam stage on the host.
#include "problems/gaussian_splatting/train/run_adam_stage.h"

namespace vesta::gs {

template void RunAdamStage<CpuBackend<float>>(TrainingSession& session, SplatModel& model);

}  // namespace vesta::gs
