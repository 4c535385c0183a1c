// SPDX-License-Identifier: Apache-2.0
// SIMD vectors in compressed form: only selected lanes are stored, one after the other, as float or Half.
// The function Load of PackedLanes<E, V>, called with p and bits, returns a vector V. If bit i is set, lane i is the
// next element of the array p of type E; otherwise it is 0. It may read up to kPackedOverread elements from p, for any
// bits. Store(p, bits, x) is the inverse.
#pragma once

#include <array>

#include "kernels/math/half.h"
#include "kernels/math/lanes.h"

namespace vesta {
inline namespace VESTA_ISA {

// Number of elements that must be readable from the start of the last compressed vector.
inline constexpr int kPackedOverread = 16;

template <class E, class V>
struct PackedLanes;

template <>
struct PackedLanes<double, double> {
  static double Load(const double* p, std::uint32_t bits) { return bits != 0 ? *p : 0; }
  static void Store(double* p, std::uint32_t bits, double x) {
    if (bits != 0) *p = x;
  }
};

template <>
struct PackedLanes<Half, double> {
  static double Load(const Half* p, std::uint32_t bits) { return bits != 0 ? double{FromHalf(*p)} : 0; }
  static void Store(Half* p, std::uint32_t bits, double x) {
    if (bits != 0) *p = ToHalf(static_cast<float>(x));
  }
};

// Writes convert(lane) for each lane whose bit is set.
template <class E, class Convert>
inline void StorePacked(E* to, std::uint32_t bits, const FloatLanes& x, const Convert& convert) {
  alignas(64) float lane[FloatLanes::size];
  x.store_aligned(lane);
  for (; bits != 0; bits &= bits - 1) *to++ = convert(lane[std::countr_zero(bits)]);
}

#if defined(__AVX512F__)

// Mask of the first n lanes, where n is the number of set bits.
inline __mmask16 FirstLanes(std::uint32_t bits) { return static_cast<__mmask16>((1U << std::popcount(bits)) - 1); }

template <>
struct PackedLanes<float, FloatLanes> {
  static FloatLanes Load(const float* p, std::uint32_t bits) {
    return _mm512_maskz_expandloadu_ps(static_cast<__mmask16>(bits), p);
  }
  static void Store(float* p, std::uint32_t bits, const FloatLanes& x) {
    // In two steps, because compressing directly to memory is slow on some processors.
    _mm512_mask_storeu_ps(p, FirstLanes(bits), _mm512_maskz_compress_ps(static_cast<__mmask16>(bits), x));
  }
};

template <>
struct PackedLanes<Half, FloatLanes> {
  static FloatLanes Load(const Half* p, std::uint32_t bits) {
    const __m512 all = _mm512_cvtph_ps(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)));
    return _mm512_maskz_expand_ps(static_cast<__mmask16>(bits), all);
  }
  static void Store(Half* p, std::uint32_t bits, const FloatLanes& x) {
    const __m512 packed = _mm512_maskz_compress_ps(static_cast<__mmask16>(bits), x);
    // Rounds and clamps like ToHalf.
    const __m512 limit = _mm512_set1_ps(kLargestHalf);
    const __m512 bounded = _mm512_max_ps(_mm512_min_ps(packed, limit), _mm512_sub_ps(_mm512_setzero_ps(), limit));
    const __mmask16 counts = _mm512_cmp_ps_mask(_mm512_abs_ps(packed), _mm512_set1_ps(kSmallestHalf), _CMP_GE_OQ);
    const __m256i halves = _mm512_cvtps_ph(_mm512_maskz_mov_ps(counts, bounded), _MM_FROUND_TO_NEAREST_INT);
    _mm256_mask_storeu_epi16(p, FirstLanes(bits), halves);
  }
};

#elif defined(__AVX2__)

// Byte i of kSourceLanes[bits] is the number of set bits below bit i.
constexpr std::array<std::uint64_t, 256> SourceLanes() {
  std::array<std::uint64_t, 256> table{};
  for (std::uint32_t bits = 0; bits < 256; ++bits) {
    for (std::uint32_t i = 0, rank = 0; i < 8; ++i) {
      table[bits] |= std::uint64_t{rank} << (8 * i);
      rank += bits >> i & 1;
    }
  }
  return table;
}
inline constexpr std::array<std::uint64_t, 256> kSourceLanes = SourceLanes();

// Moves the first lanes of x to the lanes whose bits are set, in order. The other lanes become 0.
inline FloatLanes SpreadLanes(__m256 x, std::uint32_t bits) {
  const __m256i source = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(kSourceLanes[bits])));
  const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  const __m256i set = _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(static_cast<int>(bits)), bit), bit);
  return _mm256_and_ps(_mm256_permutevar8x32_ps(x, source), _mm256_castsi256_ps(set));
}

template <>
struct PackedLanes<float, FloatLanes> {
  static FloatLanes Load(const float* p, std::uint32_t bits) { return SpreadLanes(_mm256_loadu_ps(p), bits); }
  static void Store(float* p, std::uint32_t bits, const FloatLanes& x) {
    StorePacked(p, bits, x, [](float value) { return value; });
  }
};

template <>
struct PackedLanes<Half, FloatLanes> {
  static FloatLanes Load(const Half* p, std::uint32_t bits) {
    const __m256i x = _mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
    // The exponent bias of Half is 112 smaller than that of float; the product with 2^112 corrects this.
    const __m256i magnitude = _mm256_slli_epi32(_mm256_and_si256(x, _mm256_set1_epi32(0x7fff)), 13);
    const __m256i sign = _mm256_slli_epi32(_mm256_and_si256(x, _mm256_set1_epi32(0x8000)), 16);
    const __m256 all = _mm256_or_ps(_mm256_mul_ps(_mm256_castsi256_ps(magnitude), _mm256_set1_ps(0x1p112f)),
                                    _mm256_castsi256_ps(sign));
    return SpreadLanes(all, bits);
  }
  static void Store(Half* p, std::uint32_t bits, const FloatLanes& x) { StorePacked(p, bits, x, ToHalf); }
};

#else

template <class E, class Convert>
inline FloatLanes LoadPacked(const E* from, std::uint32_t bits, const Convert& convert) {
  alignas(64) float lane[FloatLanes::size] = {};
  for (; bits != 0; bits &= bits - 1) lane[std::countr_zero(bits)] = convert(*from++);
  return FloatLanes::load_aligned(lane);
}

template <>
struct PackedLanes<float, FloatLanes> {
  static FloatLanes Load(const float* p, std::uint32_t bits) {
    return LoadPacked(p, bits, [](float value) { return value; });
  }
  static void Store(float* p, std::uint32_t bits, const FloatLanes& x) {
    StorePacked(p, bits, x, [](float value) { return value; });
  }
};

template <>
struct PackedLanes<Half, FloatLanes> {
  static FloatLanes Load(const Half* p, std::uint32_t bits) { return LoadPacked(p, bits, FromHalf); }
  static void Store(Half* p, std::uint32_t bits, const FloatLanes& x) { StorePacked(p, bits, x, ToHalf); }
};

#endif

}  // namespace VESTA_ISA
}  // namespace vesta
