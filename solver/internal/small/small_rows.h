// SPDX-License-Identifier: Apache-2.0
// The residuals of a functor with few parameters and their derivatives at one point.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <type_traits>
#include <vector>

#include "kernels/math/double_lanes.h"
#include "solver/internal/derivative_passes.h"

namespace vesta::small_internal {

// The lanes of a scalar type. A Mask has one truth value per lane. A plain number has one lane.
template <class V>
struct LaneTraits {
  using Number = V;
  using Mask = bool;
  static constexpr int kWidth = 1;
  static bool At(bool mask, int) { return mask; }
};
template <>
struct LaneTraits<DoubleLanes> {
  using Number = double;
  using Mask = DoubleLanes::Mask;
  static constexpr int kWidth = DoubleLanes::kWidth;
  static bool At(const Mask& mask, int lane) { return mask[lane]; }
};
template <class V>
using NumberOf = typename LaneTraits<V>::Number;
template <class V>
using MaskOf = typename LaneTraits<V>::Mask;
template <class V>
inline constexpr int kLanes = LaneTraits<V>::kWidth;

template <class V>
NumberOf<V>& Entry(V& v, int lane) {
  return reinterpret_cast<NumberOf<V>*>(&v)[lane];
}
template <class V>
NumberOf<V> Entry(const V& v, int lane) {
  return reinterpret_cast<const NumberOf<V>*>(&v)[lane];
}

// An array of kSize elements: on the stack up to 32 KiB, otherwise on the heap. The size is set at run time if kSize is
// negative.
template <class T, int kSize>
class SmallArray {
  static constexpr bool kInline = kSize >= 0 && kSize * static_cast<int>(sizeof(T)) <= 32768;

 public:
  // Allocates only if the array is on the heap and grows.
  void Resize(int size) {
    if constexpr (!kInline) {
      if (values_.size() < static_cast<std::size_t>(size)) values_.resize(static_cast<std::size_t>(size));
    }
  }
  T& operator[](int i) { return values_[static_cast<std::size_t>(i)]; }
  const T& operator[](int i) const { return values_[static_cast<std::size_t>(i)]; }
  T* data() { return values_.data(); }

 private:
  std::conditional_t<kInline, std::array<T, std::max(kSize, 1)>, std::vector<T>> values_;
};

// D: the dual number that the functor is evaluated with. kRows: number of residuals, negative if known at run time
// only. N: number of parameters.
template <class D, int kRows, int N>
class SmallRows {
 public:
  using V = decltype(D::a);
  static constexpr int kParameters = N;
  static constexpr bool kOnePass = D::kDerivatives == N;

  // Call it at the start of a solve. Afterwards, entries that the functor does not write are NaN.
  void Start(int rows) {
    rows_ = rows;
    duals_.Resize(rows);
    if constexpr (!kOnePass) jacobian_.Resize(rows * N);
    for (int k = 0; k < rows; ++k) MarkUnwritten(duals_[k].a);
  }
  int rows() const { return kRows >= 0 ? kRows : rows_; }

  // call(p, r) computes rows() residuals from N parameters, and returns nothing, or whether the residuals are defined.
  template <class Call>
  MaskOf<V> Evaluate(const Call& call, const V* x) {
    D p[N];
    for (int c = 0; c < N; ++c) p[c] = D(x[c]);
    auto defined = MaskOf<V>(true);
    DifferentiateInPasses(
        N, [&](int c) -> D& { return p[c]; },
        [&] {
          if constexpr (std::is_void_v<decltype(call(&p[0], duals_.data()))>) {
            call(&p[0], duals_.data());
          } else {
            defined = MaskOf<V>(call(&p[0], duals_.data()));
          }
          return true;
        },
        [&](int first, int count) {
          if constexpr (!kOnePass) {
            for (int k = 0; k < rows(); ++k) {
              for (int i = 0; i < count; ++i) jacobian_[k * N + first + i] = DerivativeOf(duals_[k], i);
            }
          }
        });
    return defined;
  }

  const D& dual(int k) const { return duals_[k]; }
  const V& value(int k) const { return duals_[k].a; }
  const V& derivative(int k, int c) const {
    if constexpr (kOnePass) {
      return DerivativeOf(duals_[k], c);
    } else {
      return jacobian_[k * N + c];
    }
  }

 private:
  static void MarkUnwritten(V& value) {
    for (int lane = 0; lane < kLanes<V>; ++lane) vesta::MarkUnwritten(Entry(value, lane));
  }

  int rows_ = 0;
  SmallArray<D, kRows> duals_;
  static constexpr int kJacobianSize = kOnePass ? 0 : std::max(kRows * N, -1);
  SmallArray<V, kJacobianSize> jacobian_;  // if there are several passes
};

}  // namespace vesta::small_internal
