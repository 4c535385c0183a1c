// A view whose camera has moved.
#pragma once

#include <vector>

#include "kernels/gaussian_splatting/camera_motion.h"
#include "problems/gaussian_splatting/cameras/view_unknowns.h"
#include "problems/gaussian_splatting/model/scene.h"
#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

// The view with its camera moved, without its image.
View MovedView(const View& view, const splat::CameraMotion& motion);

// The motion that brings one view's camera to another's pose.
splat::CameraMotion MotionBetween(const View& from, const View& to);

// The views of a scene, without images: those that are trained on with the motions of `found`, in their order; all as
// they are where that is empty. Else as many as there are training views.
std::vector<View> MovedViews(const Scene& scene, const std::vector<ViewUnknowns>& found);

// How far the motion moves the image: the median distance in pixels by which the means of the Gaussians move that the
// view sees before. 0 where it sees none. near: distance of the near plane.
double MedianShift(const SplatModel& model, const View& view, const splat::CameraMotion& motion, double near);

}  // namespace vesta::gs
