// The Adam stage on a GPU.
#include "kernels/core/device_sort.h"
#include "kernels/gaussian_splatting/device_camera.h"
#include "problems/gaussian_splatting/adam/device_adam_steps.h"
#include "problems/gaussian_splatting/cameras/view_columns.inl"
#include "problems/gaussian_splatting/cameras/view_curvature.inl"
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "problems/gaussian_splatting/train/run_adam_stage.h"

namespace vesta::gs {

template void RunAdamStage<CudaBackend<float>>(TrainingSession& session, SplatModel& model);

}  // namespace vesta::gs
