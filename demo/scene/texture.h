// SPDX-License-Identifier: Apache-2.0
// Procedural surface colours of the demo scene.
#pragma once

#include "demo/scene/vec3.h"

namespace vesta::demo {

enum class Texture { kPlanks, kRug, kWall, kPlaster, kMarble, kStripes, kPatchwork, kSpiral, kSpeckle, kRings };

// Texture::kStripes is made for a torus with this ring radius.
inline constexpr double kStripesRingRadius = 0.33;

// Returns the reflectance at a point p in the frame of the object: linear red, green and blue, 0..1. `tint` is the main
// colour in some textures; others ignore it.
Vec3 Albedo(Texture texture, const Vec3& tint, const Vec3& p);

}  // namespace vesta::demo
