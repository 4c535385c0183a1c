// SPDX-License-Identifier: Apache-2.0
// Procedural surface colours of the demo scene.
#pragma once

#include "demo/scene/vec3.h"

namespace vesta::demo {

enum class Texture { kPlanks, kRug, kWall, kPlaster, kMarble, kStripes, kPatchwork, kSpiral, kSpeckle, kRings };

// Ring radius of the torus for which kStripes is made.
inline constexpr double kStripesRingRadius = 0.33;

// Linear RGB reflectance, 0 to 1, at a point in the object's frame. `tint` is the main colour, which some textures use.
Vec3 Albedo(Texture texture, const Vec3& tint, const Vec3& p);

}  // namespace vesta::demo
