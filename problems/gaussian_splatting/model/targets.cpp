// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/model/targets.h"

#include <algorithm>

namespace vesta::gs {

double NearPlane(const Scene& scene) { return 0.01 * scene.extent; }

splat::PosedCamera ToPosedCamera(const View& view, double near) {
  splat::PosedCamera camera{};
  std::copy(view.rotation.begin(), view.rotation.end(), camera.R);
  std::copy(view.translation.begin(), view.translation.end(), camera.T);
  const auto centre = CameraCenter(view);
  std::copy(centre.begin(), centre.end(), camera.centre);
  camera.lens = view.camera.lens;
  camera.width = view.camera.width, camera.height = view.camera.height;
  camera.near = near;
  camera.eps2d = view.camera.eps2d, camera.antialiased = view.camera.antialiased;
  return camera;
}

splat::Model<float> ToKernelModel(const SplatModel& model) {
  return {model.data.data(), model.layout(), model.sh_degree};
}

SplatModel CopyOf(const splat::Model<float>& model) {
  SplatModel copy;
  static_cast<splat::ModelLayout&>(copy) = model;
  copy.data.assign(model.x, model.x + model.Size());
  return copy;
}

}  // namespace vesta::gs
