// Image quality of a model over the views of a scene, in the memory of a GPU.
#pragma once

#include <array>
#include <vector>

#include "problems/gaussian_splatting/evaluate/metrics.h"
#include "problems/gaussian_splatting/model/device_splat_backend.h"

namespace vesta::gs {

// As Renderer::Evaluate, of a model in the memory of the GPU. targets: the training views, in the order of the scene;
// the truths of test views are copied there one at a time. Holds its view and two images only while it runs; throws
// OutOfDeviceMemory.
Evaluation EvaluateOnDevice(const Scene& scene, const std::array<double, 3>& background,
                            const std::vector<TargetView<CudaBackend<float>>>& targets,
                            const splat::Model<float>& model, splat::DeviceViewWorkspace& workspace);

}  // namespace vesta::gs
