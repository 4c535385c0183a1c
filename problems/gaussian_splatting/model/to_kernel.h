// Views and models in the form of the kernels.
#pragma once

#include "kernels/gaussian_splatting/formulas/posed_camera.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// Distance of the near plane, world units: 1 % of the scene's extent. One rule for training, refining and evaluating,
// so that a written model reproduces the figures of its training.
double NearPlane(const Scene& scene);

// The kernels' form of a view and of a model.
splat::PosedCamera ToPosedCamera(const View& view, double near);
splat::Model<float> ToKernelModel(const SplatModel& model);
// A copy of a model in the memory of the host: its Gaussians alone.
SplatModel CopyOf(const splat::Model<float>& model);

}  // namespace vesta::gs
