// SPDX-License-Identifier: Apache-2.0
// Camera paths for videos: orbits, spirals, tours of the training cameras, and paths through given poses.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// One turn around the point that the scene's cameras look at.
struct Orbit {
  std::vector<View> views;
  // Widest angle between neighbouring cameras, in degrees about the circle's axis: no photograph is taken from within
  // it.
  double unseen_degrees = 0;
};

// Views along a circle whose axis passes through PointLookedAt in direction UpOf (look.h); every view looks at the
// point. Radius and height are the medians over the scene's cameras. The circle starts at the angle of the first
// camera. frames: number of views, at least 1; the last one does not repeat the first. camera: size and lens. Throws
// Error for a scene without views.
Orbit OrbitOf(const Scene& scene, const Camera& camera, int frames);

// A path for forward-facing scenes that stays among their cameras (as in Mildenhall et al. 2019, "Local light field
// fusion"): two turns in the plane perpendicular to the mean viewing direction, while moving forward and back once.
// Its reach along an axis is the 90th percentile of the cameras' distances from the mean camera along this axis.
// Forward and back, the reach is at most half of the scene's median depth. Every view looks at the point at the scene's
// median depth in front of the mean camera. frames: number of views, at least 1; the last one does not repeat the
// first. Throws Error for a scene without views, or if the views face different directions.
std::vector<View> SpiralOf(const Scene& scene, const Camera& camera, int frames);

struct Tour {
  std::vector<std::size_t> order;  // indices of views
  bool is_reordered = false;       // false: the original order
};

// A tour past all views: the original order, unless nearest neighbours and 2-opt, from the first view, give a tour that
// is more than a third shorter. Lengths are from StepBetween. The time is quadratic in the number of views.
Tour TourOf(const std::vector<View>& views, double length_unit);

// Distance between two poses: sqrt(d^2 + a^2), with the distance d of the centres in units of length_unit, and the
// angle a between the orientations in radians.
double StepBetween(const View& from, const View& to, double length_unit);

// `frames` views along a smooth path from the first of `keys` to the last. The time between keys is proportional to
// StepBetween. Centres and quaternions follow a cubic spline; quaternions are then normalised. The slope at a key is
// the slope of the parabola through the key and its two neighbours (Catmull-Rom with uneven knots). keys: at least one;
// frames: at least 1.
std::vector<View> PathThrough(const std::vector<View>& keys, double length_unit, const Camera& camera, int frames);

}  // namespace vesta::gs
