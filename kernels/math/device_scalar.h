// SPDX-License-Identifier: Apache-2.0
// Scalar operations for which a GPU has special instructions. Only these functions round differently on host and
// device. Other shared code gives equal results.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "kernels/core/hd.h"
#include "kernels/math/isa.h"

namespace vesta {
inline namespace VESTA_ISA {

// a * b + c. The host rounds twice, because std::fma would be fifty times slower on a CPU without hardware support. A
// GPU rounds once.
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

// 2^x for x in [-126, 126]. One instruction on a GPU, with relative error at most 2^-22 (PTX ISA, ex2.approx).
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

// 1 / x for x in [2^-100, 2^100]. One instruction on a GPU, with an error of at most 1 ulp (rcp.approx).
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

// Number of set bits.
VESTA_HD inline int PopCount(std::uint32_t bits) {
#if defined(__CUDA_ARCH__)
  return __popc(bits);
#else
  return std::popcount(bits);
#endif
}

// Position of the lowest set bit. At least one bit must be set.
VESTA_HD inline int LowestBit(std::uint32_t bits) {
#if defined(__CUDA_ARCH__)
  return __ffs(static_cast<int>(bits)) - 1;
#else
  return std::countr_zero(bits);
#endif
}

// Exact value of the bits of a binary16 number, which must be 0 or normal (half.h). One instruction on a GPU.
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
