// SPDX-License-Identifier: Apache-2.0
// Values as compact files store them: frames, opacities, rotations.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "kernels/gaussian_splatting/formulas/layout.h"

namespace vesta::gs {

// Splats between the two frames that files are in: x right, y down, z forward (INRIA's .ply), and x right, y up, z
// backward (.spz). One is the other after half a turn about the x axis.
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

// The nearest of 1..254 where there is anything to see, which is from an opacity of 1/255 on (docs/conventions.md),
// else 0: rounded up it would be seen. 255 is an opacity too, but its logit is infinite, and no renderer tells it from
// 254.
inline std::uint8_t OpacityByte(float logit) {
  const double parts = 255 / (1 + std::exp(-static_cast<double>(logit)));
  return parts < 1 ? std::uint8_t{0} : static_cast<std::uint8_t>(std::min(std::round(parts), 254.0));
}

// Finite: 0 and 255 are taken for the middle of the opacities that are rounded to them.
inline float OpacityLogit(std::uint8_t byte) {
  const double opacity = std::clamp(static_cast<double>(byte), 0.25, 254.75) / 255;
  return static_cast<float>(std::log(opacity / (1 - opacity)));
}

// Rotations by three of four numbers: of a unit quaternion the largest follows from the others, which are at most
// 1 / sqrt(2) each.
inline constexpr double kLargestOfSmallest = 0.70710678118654752;

struct SmallestThree {
  int largest;                 // its place in the quaternion
  std::array<double, 3> rest;  // the others in order, where the largest is positive
};

// Of a quaternion of any length but zero, its numbers in any order.
inline SmallestThree ToSmallestThree(const std::array<double, 4>& q) {
  SmallestThree result{0, {}};
  double norm2 = 0;
  for (int k = 0; k < 4; ++k) {
    const double value = q[static_cast<std::size_t>(k)];
    if (std::abs(value) > std::abs(q[static_cast<std::size_t>(result.largest)])) result.largest = k;
    norm2 += value * value;
  }
  const double scale = std::copysign(1 / std::sqrt(norm2), q[static_cast<std::size_t>(result.largest)]);
  std::size_t at = 0;
  for (int k = 0; k < 4; ++k) {
    if (k != result.largest) result.rest[at++] = scale * q[static_cast<std::size_t>(k)];
  }
  return result;
}

// In the same order. Of unit length but where the three are longer than 1, which no rotation has: then the largest is
// 0.
inline std::array<double, 4> FromSmallestThree(const SmallestThree& three) {
  const auto& [a, b, c] = three.rest;
  std::array<double, 4> q{};
  std::size_t at = 0;
  for (int k = 0; k < 4; ++k) {
    q[static_cast<std::size_t>(k)] =
        k == three.largest ? std::sqrt(std::fmax(0.0, 1 - (a * a + b * b + c * c))) : three.rest[at++];
  }
  return q;
}

}  // namespace vesta::gs
