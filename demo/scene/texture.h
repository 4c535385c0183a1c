// SPDX-License-Identifier: Apache-2.0
// Procedural surface colours.
#pragma once

#include "demo/scene/vec3.h"

namespace vesta::demo {

enum class Texture { kPlanks, kRug, kWall, kPlaster, kMarble, kStripes, kPatchwork, kSpiral, kSpeckle, kRings };

// Texture::kStripes assumes a torus with this ring radius.
inline constexpr double kStripesRingRadius = 0.33;

// The reflectance at a point p in the object's frame: linear red, green and blue, 0..1. `tint` is the main colour of
// some textures; others ignore it.
Vec3 Albedo(Texture texture, const Vec3& tint, const Vec3& p);

}  // namespace vesta::demo
