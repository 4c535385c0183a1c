// SPDX-License-Identifier: Apache-2.0
// Camera paths for videos: orbits, spirals, tours of the training cameras, and paths through given poses.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// One turn around the point that the cameras look at.
struct Orbit {
  std::vector<View> views;
  // The widest angle about the axis without a photograph, in degrees.
  double unseen_degrees = 0;
};

// A circle about PointLookedAt in the plane perpendicular to UpOf, at the median distance and height of the scene's
// cameras. It starts at the first camera and looks at the point. frames: at least 1; the last frame does not repeat the
// first. Throws Error for a scene without views.
Orbit OrbitOf(const Scene& scene, const Camera& camera, int frames);

// A path for forward-facing cameras that stays among them (as in Mildenhall et al. 2019, "Local light field fusion").
// The camera makes two turns across the mean viewing direction while it moves forward and back once. Along each axis it
// covers the offsets of nine tenths of the scene's cameras. It looks at the point at the median depth. frames: at least
// 1; the last frame does not repeat the first. Throws Error for a scene without views, or if the views face different
// directions.
std::vector<View> SpiralOf(const Scene& scene, const Camera& camera, int frames);

// The order in which to visit cameras.
struct Tour {
  std::vector<std::size_t> order;  // indices of views
  bool is_reordered = false;       // false: the original order
};

// The original order, unless another order is more than a third shorter. The other order starts at the same view and is
// found by nearest neighbours and 2-opt. Lengths are from StepBetween. Quadratic in the number of views: one second for
// 5,000.
Tour TourOf(const std::vector<View>& views, double length_unit);

// Distance between two poses: the root of the squared distance, in units of length_unit, plus the squared angle in
// radians.
double StepBetween(const View& from, const View& to, double length_unit);

// `frames` views from the first of `keys` to the last, at constant speed in StepBetween. Centres and quaternions follow
// a cubic spline; quaternions are then normalised. Its slope at a key is the slope of the parabola through three
// consecutive keys (Catmull-Rom with uneven knots). The motion is smooth, unlike slerp from key to key, which jerks at
// each key. keys: at least one; frames: at least 1.
std::vector<View> PathThrough(const std::vector<View>& keys, double length_unit, const Camera& camera, int frames);

}  // namespace vesta::gs
