// SPDX-License-Identifier: Apache-2.0
// SIMD batches as a scalar type for the templates of this folder: xsimd's batch<float>, with the width of the compiled
// instruction set. (double is a batch of one lane, see scalar.h.) Only for *.simd.cpp files and their shared headers.
#pragma once

#include <bit>
#include <cstdint>
#include <xsimd/xsimd.hpp>

#include "kernels/math/scalar.h"

namespace vesta {
inline namespace VESTA_ISA {

// The sum of all lanes.
template <class Lanes>
inline typename Lanes::value_type LaneSum(const Lanes& v) {
#if XSIMD_VERSION_MAJOR >= 10
  return xsimd::reduce_add(v);
#else
  return xsimd::hadd(v);
#endif
}

using FloatLanes = xsimd::batch<float>;
using FloatMask = FloatLanes::batch_bool_type;

template <>
struct Elementary<FloatLanes> {
  static FloatLanes Select(const FloatMask& m, const FloatLanes& a, const FloatLanes& b) {
    return xsimd::select(m, a, b);
  }
#if defined(__AVX512F__)
  // xsimd 8.1 uses separate multiply and add instructions at this width.
  static FloatLanes Fma(const FloatLanes& a, const FloatLanes& b, const FloatLanes& c) {
    return _mm512_fmadd_ps(a, b, c);
  }
  static FloatLanes Fnma(const FloatLanes& a, const FloatLanes& b, const FloatLanes& c) {
    return _mm512_fnmadd_ps(a, b, c);
  }
#else
  static FloatLanes Fma(const FloatLanes& a, const FloatLanes& b, const FloatLanes& c) { return xsimd::fma(a, b, c); }
  static FloatLanes Fnma(const FloatLanes& a, const FloatLanes& b, const FloatLanes& c) { return xsimd::fnma(a, b, c); }
#endif
  static FloatLanes Max(const FloatLanes& a, const FloatLanes& b) { return xsimd::max(a, b); }
  static FloatLanes Min(const FloatLanes& a, const FloatLanes& b) { return xsimd::min(a, b); }
  // 2^x where mask is set and x is in [-126, 0]; 0 elsewhere. With and without fused multiply-adds, the relative error
  // is at most 5e-7: 8e-8 from the minimax polynomial of degree 5, the rest from rounding.
  static FloatLanes MaskedExp2(const FloatMask& mask, const FloatLanes& x) {
#if defined(__AVX512DQ__)
    // 2^x = 2^floor(x) 2^f. The hardware computes f in [0, 1) and the scaling in one instruction each.
    const FloatLanes f = _mm512_reduce_ps(x, 0x01);
    const FloatLanes p = Quintic(f, 0.9999999250635514f, 0.6931530731988381f, 0.24015361705587057f,
                                 0.055826318019286086f, 0.008989340131009826f, 0.0018775766584552267f);
    return _mm512_maskz_scalef_ps(mask, p, x);
#else
    // Adding 1.5 * 2^23 leaves the rounded integer n in the low mantissa bits. Shifted left by 23, n becomes the
    // exponent.
    const FloatLanes magic(12582912.0f);
    const FloatLanes biased = x + magic;
    const FloatLanes f = x - (biased - magic);
    const FloatLanes p = Quintic(f, 1.0000000716546757f, 0.693146967064535f, 0.24022119723863694f,
                                 0.055507132738658184f, 0.009675541333494672f, 0.0013276471873520587f);
    // xsimd's own bitwise_cast has other arguments since version 10.
    using IntLanes = xsimd::batch<int32_t>;
    const IntLanes exponent = std::bit_cast<IntLanes>(biased) << 23;
    return Select(mask, std::bit_cast<FloatLanes>(std::bit_cast<IntLanes>(p) + exponent), FloatLanes(0));
#endif
  }

#if defined(__AVX512F__)
  // e^x, with a relative error of at most 2e-7. Unlike the function of xsimd, it has the same bits with all versions of
  // xsimd, which differ in multiply-adds at this width.
  static FloatLanes Exp(const FloatLanes& x) {
    // Beyond these bounds the result is 0 or infinite. NaN stays NaN.
    const FloatLanes bounded = _mm512_min_ps(_mm512_set1_ps(89.0f), _mm512_max_ps(_mm512_set1_ps(-104.0f), x));
    // e^x = 2^n e^r with |r| <= log(2) / 2. log(2) is the sum of a number with few digits, so that its product with n
    // is exact, and of a small one.
    const FloatLanes n =
        _mm512_roundscale_ps(bounded * FloatLanes(1.44269504f), _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
    const FloatLanes r = Fnma(n, FloatLanes(-2.12194440e-4f), Fnma(n, FloatLanes(0.693359375f), bounded));
    // The Taylor series up to r^7.
    const FloatLanes high = Quintic(r, 1.0f / 2, 1.0f / 6, 1.0f / 24, 1.0f / 120, 1.0f / 720, 1.0f / 5040);
    return _mm512_scalef_ps(Fma(Fma(high, r, FloatLanes(1)), r, FloatLanes(1)), n);
  }
#endif

  // a * b where mask is set, else 0.
  static FloatLanes MaskedProduct(const FloatMask& mask, const FloatLanes& a, const FloatLanes& b) {
#if defined(__AVX512F__)
    return _mm512_maskz_mul_ps(mask, a, b);
#else
    return Select(mask, a * b, FloatLanes(0));
#endif
  }

  // 1 / x for x in [2^-100, 2^100]. Relative error at most 3e-7: a hardware estimate and one Newton step.
  static FloatLanes Reciprocal(const FloatLanes& x) {
#if defined(__AVX512F__)
    const FloatLanes guess = _mm512_rcp14_ps(x);
#elif defined(__AVX2__)
    const FloatLanes guess = _mm256_rcp_ps(x);
#else
    return FloatLanes(1) / x;
#endif
#if defined(__AVX2__)
    return Fma(guess, Fnma(x, guess, FloatLanes(1)), guess);
#endif
  }

  // sqrt(x) for x in [2^-100, 2^100] where mask is set, else 0. Relative error at most 7e-5.
  static FloatLanes MaskedSquareRoot(const FloatMask& mask, const FloatLanes& x) {
#if defined(__AVX512F__)
    // The hardware's square root takes the time of twenty other instructions.
    return _mm512_mul_ps(x, _mm512_maskz_rsqrt14_ps(mask, x));
#else
    return xsimd::sqrt(Select(mask, x, FloatLanes(0)));
#endif
  }

 private:
  // c0 + c1 x + ... + c5 x^5.
  static FloatLanes Quintic(const FloatLanes& x, float c0, float c1, float c2, float c3, float c4, float c5) {
    const FloatLanes high = Fma(Fma(FloatLanes(c5), x, FloatLanes(c4)), x, FloatLanes(c3));
    return Fma(Fma(Fma(high, x, FloatLanes(c2)), x, FloatLanes(c1)), x, FloatLanes(c0));
  }
};

// Writes first + i to `out` for each set bit i < 16 of `bits`, in ascending order, and returns the number of set bits.
// May overwrite up to 16 elements of `out`.
inline int AppendSetBits(std::uint32_t bits, std::uint32_t first, std::uint32_t* out) {
#if defined(__AVX512F__)
  const __m512i iota = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  const __m512i all = _mm512_add_epi32(iota, _mm512_set1_epi32(static_cast<int>(first)));
  _mm512_storeu_si512(out, _mm512_maskz_compress_epi32(static_cast<__mmask16>(bits), all));
  return std::popcount(bits);
#else
  int count = 0;
  for (; bits != 0; bits &= bits - 1) out[count++] = first + static_cast<std::uint32_t>(std::countr_zero(bits));
  return count;
#endif
}

#if defined(__SSE2__)
// One step of SumLanes, which sums the lanes of several batches at once. Adds pairs of lanes within a and within b, and
// stores the results in one batch. After log2(width) steps one batch is left, whose lane i is the sum of the i-th
// batch.
template <int kLevel>
inline FloatLanes FoldLanes(const FloatLanes& a, const FloatLanes& b) {
#if defined(__AVX512F__)
  if constexpr (kLevel == 0) return _mm512_add_ps(_mm512_unpacklo_ps(a, b), _mm512_unpackhi_ps(a, b));
  if constexpr (kLevel == 1) {
    const __m512d x = _mm512_castps_pd(a), y = _mm512_castps_pd(b);
    return _mm512_add_ps(_mm512_castpd_ps(_mm512_unpacklo_pd(x, y)), _mm512_castpd_ps(_mm512_unpackhi_pd(x, y)));
  }
  if constexpr (kLevel >= 2) return _mm512_add_ps(_mm512_shuffle_f32x4(a, b, 0x88), _mm512_shuffle_f32x4(a, b, 0xdd));
#elif defined(__AVX2__)
  if constexpr (kLevel == 0) return _mm256_add_ps(_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
  if constexpr (kLevel == 1) {
    const __m256d x = _mm256_castps_pd(a), y = _mm256_castps_pd(b);
    return _mm256_add_ps(_mm256_castpd_ps(_mm256_unpacklo_pd(x, y)), _mm256_castpd_ps(_mm256_unpackhi_pd(x, y)));
  }
  if constexpr (kLevel >= 2) {
    return _mm256_add_ps(_mm256_permute2f128_ps(a, b, 0x20), _mm256_permute2f128_ps(a, b, 0x31));
  }
#else
  if constexpr (kLevel == 0) return _mm_add_ps(_mm_unpacklo_ps(a, b), _mm_unpackhi_ps(a, b));
  if constexpr (kLevel >= 1) return _mm_add_ps(_mm_movelh_ps(a, b), _mm_movehl_ps(b, a));
#endif
}

// Applies the steps kLevel, kLevel + 1, ..., log2(width) - 1 (FoldLanes) to v[0], ..., v[kCount - 1], where kCount <=
// width / 2^kLevel. Each step halves the number of batches, rounding up. The result is in v[0].
template <int kLevel, int kCount>
inline void FoldAll(FloatLanes* v) {
  if constexpr ((1 << kLevel) < static_cast<int>(FloatLanes::size)) {
    for (int i = 0; i < kCount / 2; ++i) v[i] = FoldLanes<kLevel>(v[2 * i], v[2 * i + 1]);
    if constexpr (kCount % 2 == 1) v[kCount / 2] = FoldLanes<kLevel>(v[kCount - 1], v[kCount - 1]);
    FoldAll<kLevel + 1, (kCount + 1) / 2>(v);
  }
}

// out[i] = the sum of the lanes of v[i].
template <int kCount>
inline void SumLanes(const FloatLanes* v, float* out) {
  constexpr int kWidth = static_cast<int>(FloatLanes::size), kNow = kCount < kWidth ? kCount : kWidth;
  FloatLanes part[kNow];
  for (int i = 0; i < kNow; ++i) part[i] = v[i];
  FoldAll<0, kNow>(part);
  if constexpr (kNow == kWidth) {
    part[0].store_unaligned(out);
  } else {
#if defined(__AVX512F__)
    _mm512_mask_storeu_ps(out, static_cast<__mmask16>((1U << kNow) - 1), part[0]);
#else
    alignas(64) float sums[kWidth];
    part[0].store_aligned(sums);
    for (int i = 0; i < kNow; ++i) out[i] = sums[i];
#endif
  }
  if constexpr (kCount > kWidth) SumLanes<kCount - kWidth>(v + kWidth, out + kWidth);
}
#else
template <int kCount>
inline void SumLanes(const FloatLanes* v, float* out) {
  for (int i = 0; i < kCount; ++i) out[i] = LaneSum(v[i]);
}
#endif

template <>
struct Lanes<FloatLanes> {
  using Scalar = float;
  using Mask = FloatMask;
  static constexpr int kWidth = static_cast<int>(FloatLanes::size);
  static FloatLanes Load(const float* p) { return FloatLanes::load_unaligned(p); }
  static void Store(float* p, const FloatLanes& x) { x.store_unaligned(p); }
  static FloatLanes Iota() {
    alignas(64) float lane[kWidth];
    for (int i = 0; i < kWidth; ++i) lane[i] = static_cast<float>(i);
    return FloatLanes::load_aligned(lane);
  }
  template <int kCount>
  static void SumEach(const FloatLanes* v, float* out) {
    SumLanes<kCount>(v, out);
  }
  static bool Any(const FloatMask& m) {
#if defined(__AVX512F__)
    return _kortestz_mask16_u8(m, m) == 0;
#else
    return xsimd::any(m);
#endif
  }
  static std::uint32_t Bits(const FloatMask& m) {
#if defined(__AVX512F__)
    return m.data;
#elif defined(__AVX2__)
    return static_cast<std::uint32_t>(_mm256_movemask_ps(m));
#elif defined(__SSE2__)
    return static_cast<std::uint32_t>(_mm_movemask_ps(m));
#else
    bool lane[kWidth];
    StoreMask(lane, m);
    std::uint32_t bits = 0;
    for (int i = 0; i < kWidth; ++i) bits |= static_cast<std::uint32_t>(lane[i]) << i;
    return bits;
#endif
  }
  static void StoreMask(bool* p, const FloatMask& m) { m.store_unaligned(p); }
  static FloatMask LoadMask(const bool* p) { return FloatMask::load_unaligned(p); }
};

}  // namespace VESTA_ISA
}  // namespace vesta
