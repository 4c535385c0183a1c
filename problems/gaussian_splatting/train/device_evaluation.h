// Image quality of a model over the views of a scene, in the memory of a GPU.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "problems/gaussian_splatting/lm/device_splat_problem.h"
#include "problems/gaussian_splatting/train/session.h"

namespace vesta::gs {

// As Renderer::Evaluate, of a model in the memory of the GPU. targets: the training views, in the order of the scene;
// the truths of test views are copied there one at a time. Holds its view and two images only while it runs; throws
// OutOfDeviceMemory.
Evaluation EvaluateOnDevice(const Scene& scene, const std::array<double, 3>& background,
                            const std::vector<DeviceTargetView>& targets, const splat::Model<float>& model,
                            splat::DeviceViewWorkspace& workspace);

// The same for a session, on the host where the GPU has no room for it. on_host: gives the model in its memory.
Evaluation EvaluateOrDownload(TrainingSession& session, const std::vector<DeviceTargetView>& targets,
                              const splat::Model<float>& model, splat::DeviceViewWorkspace& workspace,
                              const std::function<splat::Model<float>()>& on_host);

}  // namespace vesta::gs
