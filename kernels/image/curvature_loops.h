// Products with the curvature of the loss, and its diagonal, row by row. Included by image_kernels.simd.cpp.
#pragma once

#include "kernels/image/window_loops.h"

namespace vesta {
inline namespace VESTA_ISA {

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
  BlurredRows first(rows, images, inner, begin, end, kAsTheyAre, weigh, kNothing);
  BlurredRows second(rows, first, outer, rows.begin, rows.end, kAsTheyAre, add, kNothing);
  second.MakeUpTo(rows.end);
}

template <class S>
void BlurAdd(const RowRange<S>& rows, const BlurAddArgs<S>& args) {
  const S scale = args.scale;
  const auto load = [&](Index i, const auto& access) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    return Fields<1, T>{{access.Load(args.in + i)}};
  };
  const auto add = [&](int row, int column, const auto& access, const auto& blurred) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    const Index i = PositionOf(rows, row, column);
    access.Store(args.out + i, Fma(T(scale), blurred.f[0], access.Load(args.d + i)));
  };
  BlurRows<1, 1>(rows, load, kAsTheyAre, add, kNothing);
}

template <class S>
void Root(const RowRange<S>& rows, const RootArgs<S>& args) {
  const LossTerms<S> loss = args.loss;
  ScratchRows<S> scratch(rows);
  WindowBlur<3, 3, S> inner(rows, scratch), outer(rows, scratch);
  const int begin = outer.InputBegin(rows.begin), end = outer.InputEnd(rows.end);
  const auto load = [&](Index i, const auto& access) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    const T v = access.Load(args.v + i), x = access.Load(loss.rendered + i);
    return Fields<3, T>{{v, x * v, (x - access.Load(loss.truth + i)) * v}};
  };
  const auto weigh = [&](int row, int column, const auto& access, const auto& blurred) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    const Index i = PositionOf(rows, row, column);
    const T p = access.Load(args.p + i), q = access.Load(args.q + i), s = access.Load(args.s + i);
    const T weighted = access.Load(args.weight + i) * SsimTangent(p, q, s, blurred.f[0], blurred.f[1], blurred.f[2]);
    outer.StoreRows(row, 0, column, access, p * weighted);
    outer.StoreRows(row, 1, column, access, q * weighted);
    outer.StoreRows(row, 2, column, access, s * weighted);
  };
  const auto add = [&](int row, int column, const auto& access, const auto& blurred) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    const Index i = PositionOf(rows, row, column);
    const T x = access.Load(loss.rendered + i);
    const T e = x - access.Load(loss.truth + i);
    const T pointwise = T(loss.l1) * PixelPenalty<T>(e, loss.penalty).Curvature(loss.penalty);
    const T by_ssim = SsimAdjoint(x, e, blurred.f[0], blurred.f[1], blurred.f[2]);
    access.Store(args.out + i, Fma(T(loss.ssim), by_ssim, pointwise * access.Load(args.v + i)));
  };
  ImageRows images(rows, inner, inner.InputBegin(begin), load);
  BlurredRows first(rows, images, inner, begin, end, kAsTheyAre, weigh, kNothing);
  BlurredRows second(rows, first, outer, rows.begin, rows.end, kAsTheyAre, add, kNothing);
  second.MakeUpTo(rows.end);
}

template <class S>
void RootDiagonal(const RowRange<S>& rows, const RootArgs<S>& args) {
  const LossTerms<S> loss = args.loss;
  const auto load = [&](Index i, const auto& access) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    const SsimRootProducts<T> w(access.Load(args.weight + i), access.Load(args.p + i), access.Load(args.q + i),
                                access.Load(args.s + i));
    return Fields<6, T>{{w.pp, w.qq, w.ss, w.pq, w.ps, w.qs}};
  };
  const auto combine = [&](int row, int column, const auto& access, const auto& blurred) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    const Index i = PositionOf(rows, row, column);
    const T x = access.Load(loss.rendered + i);
    const T e = x - access.Load(loss.truth + i);
    const auto& f = blurred.f;
    const T root = SsimRootDiagonal(x, e, f[0], f[1], f[2], f[3], f[4], f[5]);
    const T pointwise = PixelPenalty<T>(e, loss.penalty).Curvature(loss.penalty);
    access.Store(args.out + i, Fma(T(loss.ssim), root, T(loss.l1) * pointwise));
  };
  BlurRows<6, 6>(rows, load, kAsTheyAre, combine, kNothing);
}

}  // namespace VESTA_ISA
}  // namespace vesta
