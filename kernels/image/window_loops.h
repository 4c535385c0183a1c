// SPDX-License-Identifier: Apache-2.0
// Row loops that compute the value of the loss and the SSIM windows, and parts that other loops share. For
// image_kernels.simd.cpp.
#pragma once

#include "kernels/image/block_lanes.h"  // before the formulas, which call its functions
#include "kernels/image/photometric_formula.h"
#include "kernels/image/row_blur.h"

namespace vesta {
inline namespace VESTA_ISA {

// One sum per row of a block. Values are first added lane by lane, in S. The lanes are then added in double.
template <class S>
struct RowSums {
  using V = xsimd::batch<S>;
  using T = Several<V, kBlockRows<S>>;
  T lanes = T(S(0));

  void Add(const T& values) { lanes = lanes + values; }
  // Writes the totals of the first `count` rows to every third element of `sums`, and resets them.
  void WriteAndReset(int count, double* sums) {
    for (int r = 0; r < count; ++r) {
      alignas(64) S lane[V::size];
      lanes.v[r].store_aligned(lane);
      double total = 0.0;
      for (const S value : lane) total += static_cast<double>(value);
      sums[3 * r] = total;
    }
    lanes = T(S(0));
  }
};

constexpr auto kIdentity = [](const auto& fields) { return fields; };
constexpr auto kNothing = [](int, int) {};

// Returns a function that loads u = x + y and e = x - y of two images. kWithSquares computes the four fields of an SSIM
// window from u and e.
template <class S>
auto SumAndDifference(const S* rendered, const S* truth) {
  return [=](Index i, const auto& access) {
    const auto x = access.Load(rendered + i), y = access.Load(truth + i);
    return Fields<2, std::remove_const_t<decltype(x)>>{{x + y, x - y}};
  };
}
constexpr auto kWithSquares = []<class T>(const Fields<2, T>& stored) {
  const T &u = stored.f[0], &e = stored.f[1];
  return Fields<4, T>{{u, e, u * u, e * e}};
};
template <class T>
SsimWindow<T> WindowOf(const Fields<4, T>& blurred) {
  return SsimWindow<T>(blurred.f[0], blurred.f[1], blurred.f[2], blurred.f[3]);
}

// Computes the blurred rows of the range, from fields that `load` reads.
template <int kStored, int N, class S, class Load, class Derive, class Out, class EndRows>
void BlurRows(const RowRange<S>& rows, const Load& load, const Derive& derive, const Out& out,
              const EndRows& end_rows) {
  ScratchRows<S> scratch(rows);
  WindowBlur<kStored, N, S> blur(rows, scratch);
  ImageRows images(rows, blur, blur.InputBegin(rows.begin), load);
  BlurredRows blurred(rows, images, blur, rows.begin, rows.end, derive, out, end_rows);
  blurred.ComputeUpTo(rows.end);
}

// Sums of the pixel penalties.
template <class S>
struct PenaltySums {
  RowSums<S> absolute, value;

  template <class Access, class T>
  void Add(const Access& access, const PixelPenalty<T>& penalty) {
    absolute.Add(access.ZeroOutside(penalty.absolute));
    value.Add(access.ZeroOutside(penalty.value));
  }
  void WriteAndReset(int count, double* sums) {
    absolute.WriteAndReset(count, sums);
    value.WriteAndReset(count, sums + 1);
  }
};

// The sums of one row; the next rows follow.
template <class S>
double* SumsOf(const LossTerms<S>& loss, const RowRange<S>& rows, int row) {
  return loss.row_sums + 3 * (Index{rows.plane} * rows.height + row);
}

template <class S>
void Value(const RowRange<S>& rows, const ValueArgs<S>& args) {
  const LossTerms<S> loss = args.loss;
  PenaltySums<S> penalties;
  RowSums<S> dissimilarity;
  const auto measure = [&](int row, int column, const auto& access, const auto& blurred) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    const Index i = PositionOf(rows, row, column);
    dissimilarity.Add(access.ZeroOutside(WindowOf(blurred).Dissimilarity()));
    penalties.Add(access, PixelPenalty<T>(access.Load(loss.rendered + i) - access.Load(loss.truth + i), loss.penalty));
  };
  const auto end_rows = [&](int row, int count) {
    penalties.WriteAndReset(count, SumsOf(loss, rows, row));
    dissimilarity.WriteAndReset(count, SumsOf(loss, rows, row) + 2);
  };
  BlurRows<2, 4>(rows, SumAndDifference(loss.rendered, loss.truth), kWithSquares, measure, end_rows);
}

}  // namespace VESTA_ISA
}  // namespace vesta
