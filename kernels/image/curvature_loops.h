// SPDX-License-Identifier: Apache-2.0
// Products with the curvature of the loss, row by row. Included by image_kernels.simd.cpp.
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

}  // namespace VESTA_ISA
}  // namespace vesta
