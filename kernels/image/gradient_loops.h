// SPDX-License-Identifier: Apache-2.0
// Row loops for the gradient of the loss and for products with its curvature operator W (arguments: image_kernels.h).
// For image_kernels.simd.cpp.
#pragma once

#include "kernels/image/window_loops.h"

namespace vesta {

inline namespace VESTA_ISA {

// Gradient, and optionally diagonal and window curvature, of kQuadratic.
template <class S>
void Gradient(const RowRange<S>& rows, const GradientArgs<S>& args) {
  const LossTerms<S> loss = args.loss;
  ScratchRows<S> scratch(rows);
  WindowBlur<2, 4, S> windows(rows, scratch);
  WindowBlur<3, 3, S> slopes(rows, scratch);
  const int begin = slopes.InputBegin(rows.begin), end = slopes.InputEnd(rows.end);

  // Computes the slopes of all windows that contain a pixel of the range. Sums and the stored window curvature cover
  // only the windows centred in the range.
  RowSums<S> dissimilarity;
  const auto measure = [&](int row, int column, const auto& access, const auto& blurred) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    const SsimWindow<T> window = WindowOf(blurred);
    const SsimSlopes<T> slope(window);
    dissimilarity.Add(access.ZeroOutside(window.Dissimilarity()));
    slopes.StoreRows(row, 0, column, access, slope.p);
    slopes.StoreRows(row, 1, column, access, slope.q);
    slopes.StoreRows(row, 2, column, access, slope.s);
    if (args.curvature == nullptr || row < rows.begin || row >= rows.end) return;
    access.Store(args.curvature + PositionOf(rows, row, column), SsimWindowCurvature(window, slope));
  };
  const auto end_windows = [&](int row, int count) {
    double unused[3 * kBlockRows<S>];
    dissimilarity.WriteAndReset(count, row >= rows.begin && row < rows.end ? SumsOf(loss, rows, row) + 2 : unused);
  };

  PenaltySums<S> penalties;
  const auto combine = [&](int row, int column, const auto& access, const auto& blurred) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    const Index i = PositionOf(rows, row, column);
    const T x = access.Load(loss.rendered + i);
    const T e = x - access.Load(loss.truth + i);
    const PixelPenalty<T> penalty(e, loss.penalty);
    penalties.Add(access, penalty);
    const T by_ssim = SsimAdjoint(x, e, blurred.f[0], blurred.f[1], blurred.f[2]);
    access.Store(args.gradient + i, Fma(T(loss.ssim), by_ssim, T(loss.l1) * penalty.derivative));
    if (args.diagonal == nullptr) return;
    const T curvature = T(loss.l1) * penalty.Curvature(loss.penalty);
    access.Store(args.diagonal + i, Fma(T(loss.ssim), blurred.f[2], curvature));
  };
  const auto end_rows = [&](int row, int count) { penalties.WriteAndReset(count, SumsOf(loss, rows, row)); };

  const auto load = SumAndDifference(loss.rendered, loss.truth);
  ImageRows images(rows, windows, windows.InputBegin(begin), load);
  BlurredRows first(rows, images, windows, begin, end, kWithSquares, measure, end_windows);
  BlurredRows second(rows, first, slopes, rows.begin, rows.end, kIdentity, combine, end_rows);
  second.ComputeUpTo(rows.end);
}

// Gradient and diagonal of kRootCenter.
template <class S>
void Center(const RowRange<S>& rows, const CenterArgs<S>& args) {
  const LossTerms<S> loss = args.loss;
  const S centre = rows.taps[kWindowRadius] * rows.taps[kWindowRadius];
  PenaltySums<S> penalties;
  RowSums<S> dissimilarity;
  const auto measure = [&](int row, int column, const auto& access, const auto& blurred) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    const Index i = PositionOf(rows, row, column);
    const T x = access.Load(loss.rendered + i);
    const T e = x - access.Load(loss.truth + i);
    const SsimWindow<T> window = WindowOf(blurred);
    const SsimSlopes<T> slopes(window);
    const PixelPenalty<T> penalty(e, loss.penalty);
    const T value = window.Dissimilarity();
    dissimilarity.Add(access.ZeroOutside(value));
    penalties.Add(access, penalty);
    const T by_center = SsimCenterSlope(T(centre), x, e, slopes);
    access.Store(args.gradient + i, Fma(T(loss.ssim), by_center, T(loss.l1) * penalty.derivative));
    if (args.diagonal == nullptr) return;
    const T root = SsimCenterCurvature(T(loss.ssim), by_center, value);
    access.Store(args.diagonal + i, Fma(T(loss.l1), penalty.Curvature(loss.penalty), root));
  };
  const auto end_rows = [&](int row, int count) {
    penalties.WriteAndReset(count, SumsOf(loss, rows, row));
    dissimilarity.WriteAndReset(count, SumsOf(loss, rows, row) + 2);
  };
  BlurRows<2, 4>(rows, SumAndDifference(loss.rendered, loss.truth), kWithSquares, measure, end_rows);
}

// Products with W of kQuadratic.
template <class S>
void Curvature(const RowRange<S>& rows, const CurvatureArgs<S>& args) {
  const S scale = args.scale;
  ScratchRows<S> scratch(rows);
  WindowBlur<1, 1, S> inner(rows, scratch), outer(rows, scratch);
  const int begin = outer.InputBegin(rows.begin), end = outer.InputEnd(rows.end);
  const auto load = [&](Index i, const auto& access) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    return Fields<1, T>{{access.Load(args.v + i)}};
  };
  const auto weigh = [&](int row, int column, const auto& access, const auto& blurred) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    const T c = access.Load(args.c + PositionOf(rows, row, column));
    outer.StoreRows(row, 0, column, access, c * blurred.f[0]);
  };
  const auto add = [&](int row, int column, const auto& access, const auto& blurred) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    const Index i = PositionOf(rows, row, column);
    access.Store(args.out + i, Fma(T(scale), blurred.f[0], access.Load(args.d + i) * access.Load(args.v + i)));
  };
  ImageRows images(rows, inner, inner.InputBegin(begin), load);
  BlurredRows first(rows, images, inner, begin, end, kIdentity, weigh, kNothing);
  BlurredRows second(rows, first, outer, rows.begin, rows.end, kIdentity, add, kNothing);
  second.ComputeUpTo(rows.end);
}

}  // namespace VESTA_ISA
}  // namespace vesta
