// SPDX-License-Identifier: Apache-2.0
// Views with moved cameras, and views that share a lens.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "kernels/gaussian_splatting/projection/camera_motion.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// Leaves out the image.
View MovedView(const View& view, const splat::CameraMotion& motion);

// Applies the found motion and lens, but not the exposure. A returned View has no image.
View AsFound(const View& view, const ViewUnknowns& found);
splat::PosedCamera AsFound(const splat::PosedCamera& given, const ViewUnknowns& found);

// Maps the pose of `from` to the pose of `to`.
splat::CameraMotion MotionBetween(const View& from, const View& to);

// The lens change of each view of a scene. `found` has one entry per training view, in order; empty: no changes.
// Another view has the change of a training view with an equal given camera, or none.
std::vector<LensChange> LensesOf(const Scene& scene, const std::vector<ViewUnknowns>& found);

// The views of a scene, without images: training views with the found motion and lens, others with their pose and the
// lens of LensesOf.
std::vector<View> MovedViews(const Scene& scene, const std::vector<ViewUnknowns>& found);

// How far the image moves between two views: the median distance, in pixels, between the two projections of each
// Gaussian mean. Only Gaussians visible in `from` count; 0 without any. near: distance of the near plane.
double MedianShift(const SplatModel& model, const View& from, const View& to, double near);

struct SharedLenses {
  std::vector<std::size_t> of;  // lens index of each view
  std::vector<int> views;       // number of views of each lens

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
