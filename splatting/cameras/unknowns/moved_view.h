// SPDX-License-Identifier: Apache-2.0
// Views with moved cameras, and the views that share a lens.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "kernels/gaussian_splatting/projection/camera_motion.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// The view with its camera moved, without its image.
View MovedView(const View& view, const splat::CameraMotion& motion);

// Applies the found motion and lens, without exposure or image.
View AsFound(const View& view, const ViewUnknowns& found);
splat::PosedCamera AsFound(const splat::PosedCamera& given, const ViewUnknowns& found);

// The motion that maps the pose of `from` to the pose of `to`.
splat::CameraMotion MotionBetween(const View& from, const View& to);

// The lens change for each view of a scene. Training views take it from `found`, in order; other views take the change
// of their camera. `found` is empty (no changes) or has one entry per training view.
std::vector<LensChange> LensesOf(const Scene& scene, const std::vector<ViewUnknowns>& found);

// The views of a scene, without images: training views with the found motion and lens, others with the lens found for
// their camera (LensesOf).
std::vector<View> MovedViews(const Scene& scene, const std::vector<ViewUnknowns>& found);

// Median distance in pixels between the projections of the Gaussian means in two views, over the Gaussians visible in
// the first; 0 without any. near: distance of the near plane.
double MedianShift(const SplatModel& model, const View& from, const View& to, double near);

// The lenses of views, and which views share one.
struct SharedLenses {
  std::vector<std::size_t> of;  // the lens index of each view
  std::vector<int> views;       // the number of views of each lens

  std::size_t size() const { return views.size(); }
  // The first view with this lens.
  std::size_t First(std::size_t lens) const {
    return static_cast<std::size_t>(std::ranges::find(of, lens) - of.begin());
  }
};

// Views share a lens if their given cameras are equal.
inline bool ShareALens(const View& one, const View& other) { return one.camera == other.camera; }
SharedLenses LensesSharedBy(const std::vector<const View*>& views);

}  // namespace vesta::gs
