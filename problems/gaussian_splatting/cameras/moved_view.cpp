#include "problems/gaussian_splatting/cameras/moved_view.h"

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/gaussian_splatting/layout.h"
#include "kernels/gaussian_splatting/splat_view.h"
#include "problems/gaussian_splatting/model/median.h"
#include "problems/gaussian_splatting/model/to_kernel.h"

namespace vesta::gs {

View MovedView(const View& view, const splat::CameraMotion& motion) {
  View moved;
  moved.name = view.name, moved.image_path = view.image_path, moved.role = view.role;
  moved.camera = view.camera, moved.rotation = view.rotation, moved.translation = view.translation;
  splat::MovePose(motion, moved.rotation.data(), moved.translation.data());
  return moved;
}

splat::CameraMotion MotionBetween(const View& from, const View& to) {
  return splat::MotionBetween(from.rotation.data(), from.translation.data(), to.rotation.data(), to.translation.data());
}

std::vector<View> MovedViews(const Scene& scene, const std::vector<ViewUnknowns>& found) {
  std::vector<View> views;
  std::size_t trained = 0;
  for (const View& view : scene.views) {
    const bool is_found = view.is_trained() && !found.empty();
    VESTA_CHECK(!is_found || trained < found.size(), "{} motions are fewer than the training views", found.size());
    views.push_back(MovedView(view, is_found ? found[trained++].motion : splat::CameraMotion{}));
  }
  return views;
}

double MedianShift(const SplatModel& model, const View& view, const splat::CameraMotion& motion, double near) {
  const splat::PosedCamera before = ToPosedCamera(view, near), after = Moved(before, motion);
  splat::SplatView<float> splats;
  splat::ViewWorkspace<float> workspace;
  const double background[3] = {};
  splats.Build(ToKernelModel(model), before, background, workspace);
  const auto pixel = [&](const splat::PosedCamera& camera, Index i) {
    double t[3];
    for (int k = 0; k < 3; ++k) {
      t[k] = camera.T[k];
      for (int j = 0; j < 3; ++j)
        t[k] += camera.R[3 * k + j] * static_cast<double>(model.attribute(splat::kMean + j)[i]);
    }
    std::array<double, 2> uv{};
    splat::PixelOf(camera.lens, t, uv[0], uv[1]);
    return uv;
  };
  std::vector<double> shifts;
  for (Index i = 0; i < model.count; ++i) {
    if (splats.rank_of()[i] < 0) continue;
    const auto from = pixel(before, i), to = pixel(after, i);
    const double shift = std::hypot(to[0] - from[0], to[1] - from[1]);
    if (std::isfinite(shift)) shifts.push_back(shift);
  }
  return shifts.empty() ? 0 : Median(std::move(shifts));
}

}  // namespace vesta::gs
