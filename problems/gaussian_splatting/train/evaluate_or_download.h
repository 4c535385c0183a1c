// The quality of a model on a GPU, for a session.
#pragma once

#include <functional>
#include <vector>

#include "problems/gaussian_splatting/evaluate/device_evaluation.h"
#include "problems/gaussian_splatting/train/session.h"

namespace vesta::gs {

// EvaluateOnDevice, on the host where the GPU has no room for it. on_host: gives the model in its memory.
Evaluation EvaluateOrDownload(TrainingSession& session, const std::vector<TargetView<CudaBackend<float>>>& targets,
                              const splat::Model<float>& model, splat::DeviceViewWorkspace& workspace,
                              const std::function<splat::Model<float>()>& on_host);

}  // namespace vesta::gs
