#include "problems/gaussian_splatting/model/to_kernel.h"

#include <algorithm>

namespace vesta::gs {

double NearPlane(const Scene& scene) { return 0.01 * scene.extent; }

splat::PinholeView ToPinhole(const View& view, double near) {
  splat::PinholeView pinhole{};
  std::copy(view.rotation.begin(), view.rotation.end(), pinhole.R);
  std::copy(view.translation.begin(), view.translation.end(), pinhole.T);
  const auto centre = CameraCenter(view);
  std::copy(centre.begin(), centre.end(), pinhole.centre);
  pinhole.fx = view.camera.fx, pinhole.fy = view.camera.fy;
  pinhole.cx = view.camera.cx, pinhole.cy = view.camera.cy;
  pinhole.width = view.camera.width, pinhole.height = view.camera.height;
  pinhole.near = near;
  return pinhole;
}

splat::Model<float> ToKernelModel(const SplatModel& model) {
  return {model.data.data(), model.count, model.sh_degree, model.sh_degree};
}

}  // namespace vesta::gs
