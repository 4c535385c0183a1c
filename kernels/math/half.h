// SPDX-License-Identifier: Apache-2.0
// 16-bit floating-point numbers in the layout of IEEE 754 binary16, without its subnormals, infinities and NaN.
#pragma once

#include <bit>
#include <cstdint>

#include "kernels/math/device_scalar.h"
#include "kernels/math/isa.h"

namespace vesta {
inline namespace VESTA_ISA {

struct Half {
  std::uint16_t bits;
};

inline constexpr float kSmallestHalf = 0x1p-14f, kLargestHalf = 65504.0f;

// Rounds to nearest, ties to even. The relative error is at most 2^-11 for kSmallestHalf <= |x| <= kLargestHalf.
// Smaller |x| gives 0. Larger |x| gives +-kLargestHalf, and so does NaN of either sign. The result is the same on every
// machine.
VESTA_HD inline Half ToHalf(float x) {
  const auto all = std::bit_cast<std::uint32_t>(x);
  const std::uint32_t sign = all >> 16 & 0x8000u, magnitude = all & 0x7fffffffu;
  if (magnitude < std::bit_cast<std::uint32_t>(kSmallestHalf)) return {static_cast<std::uint16_t>(sign)};
  if (magnitude > std::bit_cast<std::uint32_t>(kLargestHalf)) return {static_cast<std::uint16_t>(sign | 0x7bffu)};
  const std::uint32_t rounded = magnitude + 0xfffu + (magnitude >> 13 & 1u);
  return {static_cast<std::uint16_t>(sign | ((rounded >> 13) - (112u << 10)))};
}

// The conversion is exact.
VESTA_HD inline float FromHalf(Half h) { return FloatOfHalfBits(h.bits); }

}  // namespace VESTA_ISA
}  // namespace vesta
