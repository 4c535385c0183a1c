// SPDX-License-Identifier: Apache-2.0
// Views whose cameras have moved, and which views share a lens.
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

// The same, and its lens as it was found.
View AsFound(const View& view, const ViewUnknowns& found);
splat::PosedCamera AsFound(const splat::PosedCamera& given, const ViewUnknowns& found);

// The motion that brings one view's camera to another's pose.
splat::CameraMotion MotionBetween(const View& from, const View& to);

// What was found of the lens of each view of a scene: of those that are trained on, in their order, and of the others
// by their camera. Nothing where `found` is empty; else as many as there are training views.
std::vector<LensChange> LensesOf(const Scene& scene, const std::vector<ViewUnknowns>& found);

// The views of a scene, without images: those that are trained on as found, the others with the lens that was found of
// their camera (LensesOf).
std::vector<View> MovedViews(const Scene& scene, const std::vector<ViewUnknowns>& found);

// How far apart the images of two views are: the median distance in pixels between what they make of the means of the
// Gaussians that the first one sees. 0 where it sees none. near: distance of the near plane.
double MedianShift(const SplatModel& model, const View& from, const View& to, double near);

// Which views were taken through one lens.
struct SharedLenses {
  std::vector<std::size_t> of;  // of each view, the number of its lens
  std::vector<int> views;       // of each lens, how many have it

  std::size_t size() const { return views.size(); }
  // The first view that has it.
  std::size_t First(std::size_t lens) const {
    return static_cast<std::size_t>(std::ranges::find(of, lens) - of.begin());
  }
};

// Views share a lens where their cameras were given alike.
inline bool ShareALens(const View& one, const View& other) { return one.camera == other.camera; }
SharedLenses LensesSharedBy(const std::vector<const View*>& views);

}  // namespace vesta::gs
