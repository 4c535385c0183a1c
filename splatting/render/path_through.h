// A smooth path through given cameras.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// How far it is from one pose to the other: lengths in so many world units and angles in radians, as the hypotenuse of
// the two.
double StepBetween(const View& from, const View& to, double length_unit);

// So many views from the first of `keys` to the last at equal speed by StepBetween. Centres follow a cubic spline with
// the slopes of the parabola through each three (Catmull-Rom's, for knots that lie apart as the keys do), and so do the
// quaternions, which are normalised: that is smooth where slerp from key to key would jerk at each. keys: at least one;
// frames: at least 1.
std::vector<View> PathThrough(const std::vector<View>& keys, double length_unit, const Camera& camera, int frames);

}  // namespace vesta::gs
