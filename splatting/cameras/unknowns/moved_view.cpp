// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/unknowns/moved_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/view/splat_view.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

View MovedView(const View& view, const splat::CameraMotion& motion) {
  View moved;
  moved.name = view.name, moved.image_path = view.image_path, moved.role = view.role;
  moved.camera = view.camera, moved.rotation = view.rotation, moved.translation = view.translation;
  moved.bent = view.bent;
  splat::MovePose(motion, moved.rotation.data(), moved.translation.data());
  return moved;
}

View AsFound(const View& view, const ViewUnknowns& found) {
  View moved = MovedView(view, found.motion);
  moved.camera.lens = found.lens.Of(view.camera.lens);
  return moved;
}

splat::CameraMotion MotionBetween(const View& from, const View& to) {
  return splat::MotionBetween(from.rotation.data(), from.translation.data(), to.rotation.data(), to.translation.data());
}

splat::PosedCamera AsFound(const splat::PosedCamera& given, const ViewUnknowns& found) {
  splat::PosedCamera camera = Moved(given, found.motion);
  camera.lens = found.lens.Of(given.lens);
  return camera;
}

std::vector<LensChange> LensesOf(const Scene& scene, const std::vector<ViewUnknowns>& found) {
  std::vector<LensChange> lenses(scene.views.size());
  if (found.empty()) return lenses;
  std::vector<std::pair<const View*, LensChange>> of_cameras;
  for (std::size_t v = 0, trained = 0; v < lenses.size(); ++v) {
    if (!scene.views[v].is_trained()) continue;
    VESTA_CHECK(trained < found.size(), "{} found views are fewer than the training views", found.size());
    lenses[v] = found[trained++].lens;
    of_cameras.emplace_back(&scene.views[v], lenses[v]);
  }
  for (std::size_t v = 0; v < lenses.size(); ++v) {
    const View& view = scene.views[v];
    if (view.is_trained()) continue;
    const auto same =
        std::ranges::find_if(of_cameras, [&](const auto& other) { return ShareALens(*other.first, view); });
    if (same != of_cameras.end()) lenses[v] = same->second;
  }
  return lenses;
}

std::vector<View> MovedViews(const Scene& scene, const std::vector<ViewUnknowns>& found) {
  const std::vector<LensChange> lenses = LensesOf(scene, found);
  std::vector<View> views;
  std::size_t trained = 0;
  for (std::size_t v = 0; v < lenses.size(); ++v) {
    const View& view = scene.views[v];
    ViewUnknowns as_found;
    if (view.is_trained() && !found.empty()) as_found.motion = found[trained++].motion;
    as_found.lens = lenses[v];
    views.push_back(AsFound(view, as_found));
  }
  return views;
}

double MedianShift(const SplatModel& model, const View& from, const View& to, double near) {
  const splat::PosedCamera before = ToPosedCamera(from, near), after = ToPosedCamera(to, near);
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
    const auto there = pixel(before, i), here = pixel(after, i);
    const double shift = std::hypot(here[0] - there[0], here[1] - there[1]);
    if (std::isfinite(shift)) shifts.push_back(shift);
  }
  return shifts.empty() ? 0 : Median(std::move(shifts));
}

SharedLenses LensesSharedBy(const std::vector<const View*>& views) {
  SharedLenses lenses;
  std::vector<const View*> firsts;
  for (const View* view : views) {
    const auto same = std::ranges::find_if(firsts, [&](const View* first) { return ShareALens(*first, *view); });
    lenses.of.push_back(static_cast<std::size_t>(same - firsts.begin()));
    if (same == firsts.end()) firsts.push_back(view), lenses.views.push_back(0);
    ++lenses.views[lenses.of.back()];
  }
  return lenses;
}

}  // namespace vesta::gs
