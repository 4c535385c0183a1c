// SPDX-License-Identifier: Apache-2.0
// Axes, opacities, colours, sizes and rotations in compact files.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/math/spherical_harmonics.h"

namespace vesta::gs {

// The factor, 1 or -1, for an attribute (kernels/gaussian_splatting/formulas/layout.h) if the axes are rotated by 180
// degrees about one of them, 0 to 2. .ply files of INRIA have x right, y down, z forward. A rotation about x gives x
// right, y up, z backward (.spz); a rotation about z gives x left, y up, z forward (.glb). The other two numbers of
// means and quaternions change sign, and so do the spherical harmonics with an odd power of these two numbers.
constexpr float HalfTurnSign(int attribute, int axis = 0) {
  if (attribute < splat::kLogScale) return attribute == splat::kMean + axis ? 1.0f : -1.0f;
  if (attribute < splat::kQuaternion) return 1.0f;
  if (attribute < splat::kOpacity) {
    return attribute == splat::kQuaternion || attribute == splat::kQuaternion + 1 + axis ? 1.0f : -1.0f;
  }
  if (attribute < splat::kSh) return 1.0f;
  // Bit k: coefficient k is odd in x, y or z (kernels/math/spherical_harmonics.h).
  constexpr unsigned kOdd[] = {1u << 3 | 1u << 4 | 1u << 7 | 1u << 10 | 1u << 13 | 1u << 15,
                               1u << 1 | 1u << 4 | 1u << 5 | 1u << 9 | 1u << 10 | 1u << 11,
                               1u << 2 | 1u << 5 | 1u << 7 | 1u << 10 | 1u << 12 | 1u << 14};
  return (kOdd[(axis + 1) % 3] ^ kOdd[(axis + 2) % 3]) >> (attribute - splat::kSh) / 3 & 1u ? -1.0f : 1.0f;
}

// Converts an opacity logit to a byte: the opacity times 255, at most 254. Opacities below 1/255 become 0, because they
// are invisible (docs/conventions.md) and must stay invisible. 255 is not used: its logit is infinite, and no renderer
// distinguishes it from 254.
inline std::uint8_t OpacityByte(float logit) {
  const double parts = 255 / (1 + std::exp(-static_cast<double>(logit)));
  return parts < 1 ? std::uint8_t{0} : static_cast<std::uint8_t>(std::min(std::round(parts), 254.0));
}

// The logit of a byte. Always finite: 0 and 255 give the middle of the opacities that round to them.
inline float OpacityLogit(std::uint8_t byte) {
  const double opacity = std::clamp(static_cast<double>(byte), 0.25, 254.75) / 255;
  return static_cast<float>(std::log(opacity / (1 - opacity)));
}

// Rounds to the nearest byte.
inline std::uint8_t ToByte(double value) {
  return static_cast<std::uint8_t>(std::clamp(std::round(value), 0.0, 255.0));
}

// A colour of one channel, usually in 0..1, and SH coefficient 0.
inline double ColorOf(double dc) { return 0.5 + sh::k0 * dc; }
inline double DcOf(double color) { return (color - 0.5) / sh::k0; }

// From IEEE 754 binary16. Infinity becomes NaN, because it is not usable either.
inline float FromHalfBits(std::uint16_t bits) {
  const int exponent = bits >> 10 & 0x1f, fraction = bits & 0x3ff;
  if (exponent == 0x1f) return std::numeric_limits<float>::quiet_NaN();
  const float magnitude = exponent == 0 ? std::ldexp(static_cast<float>(fraction), -24)
                                        : std::ldexp(static_cast<float>(fraction + 0x400), exponent - 25);
  return bits & 0x8000 ? -magnitude : magnitude;
}

// The log-scale of a standard deviation. Zero, which half floats give for small sizes, becomes half of the smallest
// half float. The result for a negative number is NaN.
inline float LogScaleOf(float scale) { return std::log(scale == 0 ? 0x1p-25f : scale); }

// "Smallest three" encoding of rotations: a unit quaternion is stored without the number of largest magnitude. This
// number follows from the other three, whose magnitudes are at most 1 / sqrt(2).
inline constexpr double kLargestOfSmallest = 0.70710678118654752;

struct SmallestThree {
  int largest;                 // index of the largest number
  std::array<double, 3> rest;  // the others in order, all times -1 if the largest is negative (q and -q are equal)
};

// Any length but zero. The order of the numbers (w first or last) does not matter.
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

// A unit quaternion in the same order. If the squares of the three numbers sum to more than 1, the omitted number
// becomes 0, and the length is not 1.
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
