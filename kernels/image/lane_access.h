// Neighbouring pixels of a row as the scalar of the formulas: several vectors at once, and how they are loaded and
// stored, whole and at a row's end. Included by image_kernels.simd.cpp.
#pragma once

#include <type_traits>
#include <utility>

#include "kernels/math/lanes.h"

namespace vesta {
inline namespace VESTA_ISA {

// Calls f(0), ..., f(kCount - 1) with compile-time constants.
template <int kCount, class F>
inline void Unrolled(const F& f) {
  [&]<int... k>(std::integer_sequence<int, k...>) { (f(std::integral_constant<int, k>{}), ...); }
  (std::make_integer_sequence<int, kCount>{});
}

using DoubleLanes = xsimd::batch<double>;

template <>
struct Elementary<DoubleLanes> {
  using Mask = DoubleLanes::batch_bool_type;
  static DoubleLanes Select(const Mask& m, const DoubleLanes& a, const DoubleLanes& b) {
    return xsimd::select(m, a, b);
  }
  static DoubleLanes Fma(const DoubleLanes& a, const DoubleLanes& b, const DoubleLanes& c) {
    return xsimd::fma(a, b, c);
  }
  static DoubleLanes Fnma(const DoubleLanes& a, const DoubleLanes& b, const DoubleLanes& c) {
    return xsimd::fnma(a, b, c);
  }
  static DoubleLanes Max(const DoubleLanes& a, const DoubleLanes& b) { return xsimd::max(a, b); }
  static DoubleLanes Min(const DoubleLanes& a, const DoubleLanes& b) { return xsimd::min(a, b); }
};

inline DoubleLanes Reciprocal(const DoubleLanes& x) { return DoubleLanes(1) / x; }

// kCount vectors as one scalar. The formula of a window is a chain of some thirty dependent operations: several chains
// side by side keep the processor busy where one after the other would fill its queues with waiting instructions.
template <class V, int kCount>
struct Several {
  V v[kCount];

  Several() = default;
  explicit Several(typename V::value_type x) {
    for (V& vector : v) vector = V(x);
  }
  // Each vector of f's, from the vectors of the arguments.
  template <class F, class... Args>
  static Several Each(const F& f, const Args&... args) {
    Several result;
    Unrolled<kCount>([&](auto i) { result.v[i] = f(args.v[i]...); });
    return result;
  }
  friend Several operator+(const Several& a, const Several& b) {
    return Each([](const V& x, const V& y) { return x + y; }, a, b);
  }
  friend Several operator-(const Several& a, const Several& b) {
    return Each([](const V& x, const V& y) { return x - y; }, a, b);
  }
  friend Several operator*(const Several& a, const Several& b) {
    return Each([](const V& x, const V& y) { return x * y; }, a, b);
  }
  friend Several operator-(const Several& a) {
    return Each([](const V& x) { return -x; }, a);
  }
  friend Several Reciprocal(const Several& a) {
    return Each([](const V& x) { return Reciprocal(x); }, a);
  }
};

// Their comparison.
template <class V, int kCount>
struct SeveralMasks {
  typename V::batch_bool_type m[kCount];
};
template <class V, int kCount>
inline SeveralMasks<V, kCount> operator<(const Several<V, kCount>& a, const Several<V, kCount>& b) {
  SeveralMasks<V, kCount> result;
  Unrolled<kCount>([&](auto i) { result.m[i] = a.v[i] < b.v[i]; });
  return result;
}

template <class V, int kCount>
struct Elementary<Several<V, kCount>> {
  using T = Several<V, kCount>;
  static T Select(const SeveralMasks<V, kCount>& mask, const T& a, const T& b) {
    T result;
    Unrolled<kCount>([&](auto i) { result.v[i] = Elementary<V>::Select(mask.m[i], a.v[i], b.v[i]); });
    return result;
  }
  static T Fma(const T& a, const T& b, const T& c) {
    return T::Each([](const V& x, const V& y, const V& z) { return Elementary<V>::Fma(x, y, z); }, a, b, c);
  }
  static T Fnma(const T& a, const T& b, const T& c) {
    return T::Each([](const V& x, const V& y, const V& z) { return Elementary<V>::Fnma(x, y, z); }, a, b, c);
  }
  static T Max(const T& a, const T& b) {
    return T::Each([](const V& x, const V& y) { return Elementary<V>::Max(x, y); }, a, b);
  }
  static T Min(const T& a, const T& b) {
    return T::Each([](const V& x, const V& y) { return Elementary<V>::Min(x, y); }, a, b);
  }
};

// Memory access of kCount whole vectors of neighbouring pixels.
template <class S, int kCount>
struct WholeVectors {
  using V = xsimd::batch<S>;
  using T = Several<V, kCount>;
  T Load(const S* p) const {
    T result;
    Unrolled<kCount>([&](auto i) { result.v[i] = V::load_unaligned(p + i * V::size); });
    return result;
  }
  T LoadAligned(const S* p) const {
    T result;
    Unrolled<kCount>([&](auto i) { result.v[i] = V::load_aligned(p + i * V::size); });
    return result;
  }
  void Store(S* p, const T& x) const {
    Unrolled<kCount>([&](auto i) { x.v[i].store_unaligned(p + i * V::size); });
  }
  void StoreAligned(S* p, const T& x) const {
    Unrolled<kCount>([&](auto i) { x.v[i].store_aligned(p + i * V::size); });
  }
  T Used(const T& x) const { return x; }
};

// What lies `k` values from kCount vectors in a row, k = -16..16: unaligned loads, or, where that is faster, aligned
// ones shifted in registers. (An unaligned load of a whole cache line costs two.)
template <class S, int kCount>
class Neighbours {
 public:
  using T = Several<xsimd::batch<S>, kCount>;
  explicit Neighbours(const S* p) : p_(p) {}
  template <int k>
  T At() const {
    return WholeVectors<S, kCount>{}.Load(p_ + k);
  }

 private:
  const S* p_;
};

#if defined(__AVX512F__)
template <int kCount>
class Neighbours<float, kCount> {
 public:
  using T = Several<FloatLanes, kCount>;
  explicit Neighbours(const float* p) {
    for (int i = 0; i < kCount + 2; ++i) aligned_[i] = _mm512_load_ps(p + 16 * (i - 1));
  }
  template <int k>
  T At() const {
    T result;
    Unrolled<kCount>([&](auto i) {
      if constexpr (k == 0) {
        result.v[i] = FloatLanes(aligned_[i + 1]);
      } else if constexpr (k < 0) {
        result.v[i] = FloatLanes(Shift<16 + k>(aligned_[i], aligned_[i + 1]));
      } else {
        result.v[i] = FloatLanes(Shift<k>(aligned_[i + 1], aligned_[i + 2]));
      }
    });
    return result;
  }

 private:
  template <int k>
  static __m512 Shift(const __m512& low, const __m512& high) {
    return _mm512_castsi512_ps(_mm512_alignr_epi32(_mm512_castps_si512(high), _mm512_castps_si512(low), k));
  }
  __m512 aligned_[kCount + 2];
};
#endif

// Memory access of the first `count` pixels of a vector; other lanes are zero when loaded and not stored.
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
  // v with the other lanes zeroed.
  V Used(const V& v) const {
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
  FloatLanes Used(const FloatLanes& v) const { return _mm512_maskz_mov_ps(mask_, v); }

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
  FloatLanes Used(const FloatLanes& v) const { return _mm256_and_ps(v, _mm256_castsi256_ps(mask_)); }

 private:
  __m256i mask_;
};
#endif

// The same as WholeVectors, of the last `pixels` pixels of a row, at most as many as kCount vectors hold. The lanes of
// a scratch row behind them are stored, as zeros.
template <class S, int kCount>
class RowEnd {
 public:
  using V = xsimd::batch<S>;
  using T = Several<V, kCount>;
  explicit RowEnd(int pixels) : pixels_(pixels) {}

  T Load(const S* p) const {
    T result;
    Unrolled<kCount>([&](auto i) { result.v[i] = Part(i).Load(p + i * V::size); });
    return result;
  }
  void Store(S* p, const T& x) const {
    Unrolled<kCount>([&](auto i) { Part(i).Store(p + i * V::size, x.v[i]); });
  }
  void StoreAligned(S* p, const T& x) const {
    Unrolled<kCount>([&](auto i) { Part(i).Used(x.v[i]).store_aligned(p + i * V::size); });
  }
  T Used(const T& x) const {
    T result;
    Unrolled<kCount>([&](auto i) { result.v[i] = Part(i).Used(x.v[i]); });
    return result;
  }

 private:
  PartialVector<S> Part(int i) const {
    constexpr int kWidth = static_cast<int>(V::size);
    const int count = pixels_ - i * kWidth;
    return PartialVector<S>(count < 0 ? 0 : count < kWidth ? count : kWidth);
  }
  int pixels_;
};

// Calls f(column, access) over a row: kCount whole vectors at a time, then the rest, which is less.
template <int kCount, class S, class F>
inline void ForColumns(int width, const F& f) {
  constexpr int kStep = kCount * static_cast<int>(xsimd::batch<S>::size);
  int column = 0;
  for (; column + kStep <= width; column += kStep) f(column, WholeVectors<S, kCount>{});
  if (column < width) f(column, RowEnd<S, kCount>(width - column));
}

// The values of N fields at the same pixels.
template <int N, class T>
struct Fields {
  T f[N];
};

}  // namespace VESTA_ISA
}  // namespace vesta
