// SPDX-License-Identifier: Apache-2.0
// Camera paths for films: around the scene, spirals, tours of the training cameras, paths through given poses.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// Once around what the cameras of a scene look at.
struct Orbit {
  std::vector<View> views;
  // The widest angle about the axis from which no photograph was taken, degrees.
  double unseen_degrees = 0;
};

// A circle about PointLookedAt, in the plane across UpOf, at the median distance and height of the scene's cameras; it
// looks at the point, and begins at the first camera. frames: at least 1; another would be the first again. Throws
// Error for a scene without views.
Orbit OrbitOf(const Scene& scene, const Camera& camera, int frames);

// A path for cameras that face one way, which stays among them (as in Mildenhall et al. 2019, "Local light field
// fusion").
// Two turns across the mean of the views while the camera goes forward and back once, as far along each axis as nine
// tenths of the scene's cameras; it looks at the point at the median depth. frames: at least 1; another would be the
// first again. Throws Error for a scene without views, or one whose views face different ways.
std::vector<View> SpiralOf(const Scene& scene, const Camera& camera, int frames);

// The order in which to visit cameras.
struct Tour {
  std::vector<std::size_t> order;  // of the views
  bool is_reordered = false;       // else it is that of the views
};

// The views in their order, or, where that is more than half as long again as another that begins at the first (from
// each to the nearest one left, then untangled by reversing parts), in that. Steps are StepBetween's. Takes time by the
// square of their number: a second for 5,000.
Tour TourOf(const std::vector<View>& views, double length_unit);

// How far it is from one pose to the other: lengths in so many world units and angles in radians, as the hypotenuse of
// the two.
double StepBetween(const View& from, const View& to, double length_unit);

// So many views from the first of `keys` to the last at equal speed by StepBetween. Centres follow a cubic spline with
// the slopes of the parabola through each three (Catmull-Rom's, for knots that lie apart as the keys do), and so do the
// quaternions, which are normalised: that is smooth where slerp from key to key would jerk at each. keys: at least one;
// frames: at least 1.
std::vector<View> PathThrough(const std::vector<View>& keys, double length_unit, const Camera& camera, int frames);

}  // namespace vesta::gs
