// SPDX-License-Identifier: Apache-2.0
// Operations on scalars for which a GPU has instructions of its own. Shared code differs between host and device here
// only, and only in rounding.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "kernels/core/hd.h"
#include "kernels/math/isa.h"

namespace vesta {
inline namespace VESTA_ISA {

// a * b + c. Scalars of the host round twice: std::fma without hardware support would cost fifty times as much. A GPU
// rounds once.
template <class T>
VESTA_HD inline T MultiplyAdd(const T& a, const T& b, const T& c) {
  return a * b + c;
}
#if defined(__CUDA_ARCH__)
template <>
VESTA_HD inline float MultiplyAdd(const float& a, const float& b, const float& c) {
  return __fmaf_rn(a, b, c);
}
template <>
VESTA_HD inline double MultiplyAdd(const double& a, const double& b, const double& c) {
  return __fma_rn(a, b, c);
}
#endif

// 2^x for x in [-126, 126]; on a GPU one instruction, relative error at most 2^-22 (PTX ISA, ex2.approx).
VESTA_HD inline float Exp2(float x) {
#if defined(__CUDA_ARCH__)
  float result;
  asm("ex2.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(x));
  return result;
#else
  return std::exp2(x);
#endif
}
VESTA_HD inline double Exp2(double x) { return std::exp2(x); }

// 1 / x for x in [2^-100, 2^100]; on a GPU one instruction, at most 1 unit in the last place off (rcp.approx).
VESTA_HD inline float FastReciprocal(float x) {
#if defined(__CUDA_ARCH__)
  float result;
  asm("rcp.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(x));
  return result;
#else
  return 1 / x;
#endif
}
VESTA_HD inline double FastReciprocal(double x) { return 1 / x; }

// How many bits are set.
VESTA_HD inline int PopCount(std::uint32_t bits) {
#if defined(__CUDA_ARCH__)
  return __popc(bits);
#else
  return std::popcount(bits);
#endif
}

// The place of the lowest bit that is set; one must be.
VESTA_HD inline int LowestBit(std::uint32_t bits) {
#if defined(__CUDA_ARCH__)
  return __ffs(static_cast<int>(bits)) - 1;
#else
  return std::countr_zero(bits);
#endif
}

// The value of the bits of a binary16, which must be 0 or normal (half.h): exact; on a GPU one instruction.
VESTA_HD inline float FloatOfHalfBits(std::uint16_t bits) {
#if defined(__CUDA_ARCH__)
  float result;
  asm("cvt.f32.f16 %0, %1;" : "=f"(result) : "h"(bits));
  return result;
#else
  const std::uint32_t magnitude = bits & 0x7fffu, sign = (bits & 0x8000u) << 16;
  return std::bit_cast<float>(sign | (magnitude == 0 ? 0u : (magnitude << 13) + (112u << 23)));
#endif
}

}  // namespace VESTA_ISA
}  // namespace vesta
