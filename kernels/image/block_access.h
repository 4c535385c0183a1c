// SPDX-License-Identifier: Apache-2.0
// Loads, stores and transposition of blocks of pixels. A block has a few rows, and as many columns as a SIMD vector has
// lanes. Blocks at the right and lower image edges may be incomplete. For image_kernels.simd.cpp.
#pragma once

#include "kernels/core/span.h"
#include "kernels/image/block_lanes.h"

namespace vesta {
inline namespace VESTA_ISA {

// Access to the first `count` lanes of a vector. Load sets the other lanes to zero; Store does not write them.
template <class S>
class PartialVector {
 public:
  using V = xsimd::batch<S>;
  explicit PartialVector(int count) : count_(count) {}

  V Load(const S* p) const {
    alignas(64) S lane[V::size] = {};
    for (int i = 0; i < count_; ++i) lane[i] = p[i];
    return V::load_aligned(lane);
  }
  void Store(S* p, const V& v) const {
    alignas(64) S lane[V::size];
    v.store_aligned(lane);
    for (int i = 0; i < count_; ++i) p[i] = lane[i];
  }
  // Returns v with the other lanes set to zero.
  V ZeroOutside(const V& v) const {
    alignas(64) S lane[V::size];
    v.store_aligned(lane);
    return Load(lane);
  }

 private:
  int count_;
};

#if defined(__AVX512F__)
template <>
class PartialVector<float> {
 public:
  explicit PartialVector(int count) : mask_(static_cast<__mmask16>((1U << count) - 1)) {}
  FloatLanes Load(const float* p) const { return _mm512_maskz_loadu_ps(mask_, p); }
  void Store(float* p, const FloatLanes& v) const { _mm512_mask_storeu_ps(p, mask_, v); }
  FloatLanes ZeroOutside(const FloatLanes& v) const { return _mm512_maskz_mov_ps(mask_, v); }

 private:
  __mmask16 mask_;
};
#elif defined(__AVX2__)
template <>
class PartialVector<float> {
 public:
  explicit PartialVector(int count)
      : mask_(_mm256_cmpgt_epi32(_mm256_set1_epi32(count), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7))) {}
  FloatLanes Load(const float* p) const { return _mm256_maskload_ps(p, mask_); }
  void Store(float* p, const FloatLanes& v) const { _mm256_maskstore_ps(p, mask_, v); }
  FloatLanes ZeroOutside(const FloatLanes& v) const { return _mm256_and_ps(v, _mm256_castsi256_ps(mask_)); }

 private:
  __m256i mask_;
};
#endif

// Rows of a block: 4, or the number of lanes if this is smaller. Transposed requires that the number of lanes is a
// multiple of kBlockRows.
template <class S>
inline constexpr int kBlockRows = xsimd::batch<S>::size < 4 ? static_cast<int>(xsimd::batch<S>::size) : 4;

// Access to a complete block of kRows rows, `stride` values apart. A block (type T) has one vector per row.
template <class S, int kRows>
class WholeBlockAccess {
 public:
  using V = xsimd::batch<S>;
  using T = Several<V, kRows>;
  explicit WholeBlockAccess(Index stride) : stride_(stride) {}

  static constexpr int rows() { return kRows; }
  T Load(const S* p) const {
    T result;
    Unrolled<kRows>([&](auto r) { result.v[r] = V::load_unaligned(p + r * stride_); });
    return result;
  }
  void Store(S* p, const T& x) const {
    Unrolled<kRows>([&](auto r) { x.v[r].store_unaligned(p + r * stride_); });
  }
  T ZeroOutside(const T& x) const { return x; }

 private:
  Index stride_;
};

// Access to a block at the right or lower edge of the image. Only its first `rows` rows and their first `pixels` pixels
// exist. Load and ZeroOutside set the other pixels to zero; Store does not write them.
template <class S, int kRows>
class EdgeBlockAccess {
 public:
  using V = xsimd::batch<S>;
  using T = Several<V, kRows>;
  EdgeBlockAccess(Index stride, int rows, int pixels) : stride_(stride), rows_(rows), part_(pixels) {}

  int rows() const { return rows_; }
  T Load(const S* p) const {
    T result(S(0));
    Unrolled<kRows>([&](auto r) {
      if (r < rows_) result.v[r] = part_.Load(p + r * stride_);
    });
    return result;
  }
  void Store(S* p, const T& x) const {
    Unrolled<kRows>([&](auto r) {
      if (r < rows_) part_.Store(p + r * stride_, x.v[r]);
    });
  }
  T ZeroOutside(const T& x) const {
    T result(S(0));
    Unrolled<kRows>([&](auto r) {
      if (r < rows_) result.v[r] = part_.ZeroOutside(x.v[r]);
    });
    return result;
  }

 private:
  Index stride_;
  int rows_;
  PartialVector<S> part_;
};

// Calls f(column, access) for the blocks of one strip of kRows rows, from left to right. `width`: width of the image.
// Only the first `rows` rows of the strip are in the image. column: first column of the block. access: a
// WholeBlockAccess or an EdgeBlockAccess.
template <class S, int kRows, class F>
inline void ForBlocks(int width, int rows, const F& f) {
  constexpr int kLanes = static_cast<int>(xsimd::batch<S>::size);
  int column = 0;
  if (rows == kRows) {
    const WholeBlockAccess<S, kRows> whole(width);
    for (; column + kLanes <= width; column += kLanes) f(column, whole);
  }
  for (; column < width; column += kLanes) {
    f(column, EdgeBlockAccess<S, kRows>(width, rows, width - column < kLanes ? width - column : kLanes));
  }
}

// Transposes each group g of kRows x kRows pixels: lane kRows * g + r of vector j becomes lane kRows * g + j of
// vector r.
// The function is its own inverse.
template <class V, int kRows>
inline Several<V, kRows> Transposed(const Several<V, kRows>& rows) {
  using S = typename V::value_type;
  static_assert(V::size % kRows == 0);
  alignas(64) S in[kRows][V::size], out[kRows][V::size];
  for (int r = 0; r < kRows; ++r) rows.v[r].store_aligned(in[r]);
  for (int lane = 0; lane < static_cast<int>(V::size); ++lane) {
    for (int r = 0; r < kRows; ++r) out[lane % kRows][lane - lane % kRows + r] = in[r][lane];
  }
  Several<V, kRows> result;
  for (int r = 0; r < kRows; ++r) result.v[r] = V::load_aligned(out[r]);
  return result;
}

#if defined(__SSE2__)
inline Several<FloatLanes, 4> Transposed(const Several<FloatLanes, 4>& rows) {
#if defined(__AVX512F__)
  const auto low = [](__m512 a, __m512 b) { return _mm512_unpacklo_ps(a, b); };
  const auto high = [](__m512 a, __m512 b) { return _mm512_unpackhi_ps(a, b); };
  const auto low2 = [](__m512 a, __m512 b) { return _mm512_shuffle_ps(a, b, 0x44); };
  const auto high2 = [](__m512 a, __m512 b) { return _mm512_shuffle_ps(a, b, 0xee); };
#elif defined(__AVX2__)
  const auto low = [](__m256 a, __m256 b) { return _mm256_unpacklo_ps(a, b); };
  const auto high = [](__m256 a, __m256 b) { return _mm256_unpackhi_ps(a, b); };
  const auto low2 = [](__m256 a, __m256 b) { return _mm256_shuffle_ps(a, b, 0x44); };
  const auto high2 = [](__m256 a, __m256 b) { return _mm256_shuffle_ps(a, b, 0xee); };
#else
  const auto low = [](__m128 a, __m128 b) { return _mm_unpacklo_ps(a, b); };
  const auto high = [](__m128 a, __m128 b) { return _mm_unpackhi_ps(a, b); };
  const auto low2 = [](__m128 a, __m128 b) { return _mm_movelh_ps(a, b); };
  const auto high2 = [](__m128 a, __m128 b) { return _mm_movehl_ps(b, a); };
#endif
  const auto a = low(rows.v[0], rows.v[1]), b = high(rows.v[0], rows.v[1]);
  const auto c = low(rows.v[2], rows.v[3]), d = high(rows.v[2], rows.v[3]);
  Several<FloatLanes, 4> result;
  result.v[0] = FloatLanes(low2(a, c));
  result.v[1] = FloatLanes(high2(a, c));
  result.v[2] = FloatLanes(low2(b, d));
  result.v[3] = FloatLanes(high2(b, d));
  return result;
}
#endif

}  // namespace VESTA_ISA
}  // namespace vesta
