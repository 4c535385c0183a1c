// Values of the loss and of the windows of SSIM, row by row, and what the other loops share with that. Included by
// image_kernels.simd.cpp.
#pragma once

#include "kernels/image/lane_access.h"  // before the formulas: they call what it declares
#include "kernels/image/photometric_formula.h"
#include "kernels/image/row_blur.h"

namespace vesta {
inline namespace VESTA_ISA {

// A sum of one row: vectors in S, the lanes in double.
template <class S>
struct RowSum {
  using V = xsimd::batch<S>;
  V lanes = V(S(0));

  template <int kCount>
  void Add(const Several<V, kCount>& values) {
    Unrolled<kCount>([&](auto i) { lanes += values.v[i]; });
  }
  // The total; begins the next row.
  double Take() {
    alignas(64) S lane[V::size];
    lanes.store_aligned(lane);
    double total = 0.0;
    for (const S value : lane) total += static_cast<double>(value);
    lanes = V(S(0));
    return total;
  }
};

constexpr auto kAsTheyAre = [](const auto& fields) { return fields; };
constexpr auto kNothing = [](int) {};

// u = x + y and e = x - y of two images, of which the four fields of a window are made.
template <class S>
auto SumAndDifference(const S* rendered, const S* truth) {
  return [=](Index i, auto access) {
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

// The blurred rows of the range, from fields that `load` reads from images.
template <int kStored, int N, class S, class Load, class Derive, class Out, class EndRow>
void BlurRows(const RowRange<S>& rows, const Load& load, const Derive& derive, const Out& out, const EndRow& end_row) {
  ScratchRows<S> scratch(rows);
  WindowBlur<kStored, N, S> blur(rows, scratch);
  ImageRows images(rows, blur, blur.InputBegin(rows.begin), load);
  BlurredRows blurred(images, blur, rows.begin, rows.end, derive, out, end_row);
  blurred.MakeUpTo(rows.end);
}

// Sums of the penalty of each pixel.
template <class S>
struct PenaltySums {
  RowSum<S> absolute, value;

  template <class Access, class T>
  void Add(const Access& access, const PixelPenalty<T>& penalty) {
    absolute.Add(access.Used(penalty.absolute));
    value.Add(access.Used(penalty.value));
  }
  void Write(double* sums) {
    sums[0] = absolute.Take();
    sums[1] = value.Take();
  }
};

// The sums of one row.
template <class S>
double* SumsOf(const LossTerms<S>& loss, const RowRange<S>& rows, int row) {
  return loss.row_sums + 3 * (Index{rows.plane} * rows.height + row);
}

template <class S>
void Value(const RowRange<S>& rows, const ValueArgs<S>& args) {
  const LossTerms<S> loss = args.loss;
  PenaltySums<S> penalties;
  RowSum<S> dissimilarity;
  const auto measure = [&](int row, int column, auto access, const auto& blurred) {
    using T = typename decltype(access)::T;
    const Index i = PositionOf(rows, row, column);
    dissimilarity.Add(access.Used(WindowOf(blurred).Dissimilarity()));
    penalties.Add(access, PixelPenalty<T>(access.Load(loss.rendered + i) - access.Load(loss.truth + i), loss.penalty));
  };
  const auto end_row = [&](int row) {
    penalties.Write(SumsOf(loss, rows, row));
    SumsOf(loss, rows, row)[2] = dissimilarity.Take();
  };
  BlurRows<2, 4>(rows, SumAndDifference(loss.rendered, loss.truth), kWithSquares, measure, end_row);
}

template <class S>
void Windows(const RowRange<S>& rows, const WindowArgs<S>& args) {
  const auto measure = [&](int row, int column, auto access, const auto& blurred) {
    using T = typename decltype(access)::T;
    const Index i = PositionOf(rows, row, column);
    const SsimWindow<T> window = WindowOf(blurred);
    const SsimSlopes<T> slopes(window);
    access.Store(args.dissimilarity + i, window.Dissimilarity());
    access.Store(args.p + i, slopes.p);
    access.Store(args.q + i, slopes.q);
    access.Store(args.s + i, slopes.s);
  };
  BlurRows<2, 4>(rows, SumAndDifference(args.rendered, args.truth), kWithSquares, measure, kNothing);
}

}  // namespace VESTA_ISA
}  // namespace vesta
