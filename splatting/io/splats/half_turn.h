// Splats between the two frames that files are in: x right, y down, z forward (INRIA's .ply), and x right, y up, z
// backward (.spz). One is the other after half a turn about the x axis.
#pragma once

#include "kernels/gaussian_splatting/formulas/layout.h"

namespace vesta::gs {

// By what the turn multiplies an attribute (kernels/gaussian_splatting/formulas/layout.h): 1 or -1, in both directions.
// y and z change sign, so of the harmonics those do that are odd in y and z together, and of a quaternion its y and z.
constexpr float HalfTurnSign(int attribute) {
  if (attribute < splat::kLogScale) return attribute == splat::kMean ? 1.0f : -1.0f;
  if (attribute < splat::kQuaternion) return 1.0f;
  if (attribute < splat::kOpacity) return attribute < splat::kQuaternion + 2 ? 1.0f : -1.0f;
  if (attribute < splat::kSh) return 1.0f;
  // Bit k: coefficient k is odd (kernels/math/spherical_harmonics.h).
  constexpr unsigned kOdd = 1u << 1 | 1u << 2 | 1u << 4 | 1u << 7 | 1u << 9 | 1u << 11 | 1u << 12 | 1u << 14;
  return kOdd >> (attribute - splat::kSh) / 3 & 1u ? -1.0f : 1.0f;
}

}  // namespace vesta::gs
