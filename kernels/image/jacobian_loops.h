// Products with the Jacobian of 1 - SSIM and its transpose, row by row. Included by image_kernels.simd.cpp.
#pragma once

#include "kernels/image/window_loops.h"

namespace vesta {
inline namespace VESTA_ISA {

template <class S>
void Tangent(const RowRange<S>& rows, const JacobianArgs<S>& args) {
  const auto products = [&](Index i, const auto& access) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    const T v = access.Load(args.in + i), x = access.Load(args.rendered + i);
    return Fields<3, T>{{v, x * v, (x - access.Load(args.truth + i)) * v}};
  };
  const auto combine = [&](int row, int column, const auto& access, const auto& blurred) {
    const Index i = PositionOf(rows, row, column);
    access.Store(args.out + i, SsimTangent(access.Load(args.p + i), access.Load(args.q + i), access.Load(args.s + i),
                                           blurred.f[0], blurred.f[1], blurred.f[2]));
  };
  BlurRows<3, 3>(rows, products, kAsTheyAre, combine, kNothing);
}

template <class S>
void Adjoint(const RowRange<S>& rows, const JacobianArgs<S>& args) {
  const auto products = [&](Index i, const auto& access) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    const T v = access.Load(args.in + i);
    return Fields<3, T>{{access.Load(args.p + i) * v, access.Load(args.q + i) * v, access.Load(args.s + i) * v}};
  };
  const auto combine = [&](int row, int column, const auto& access, const auto& blurred) {
    using T = typename std::remove_cvref_t<decltype(access)>::T;
    const Index i = PositionOf(rows, row, column);
    const T x = access.Load(args.rendered + i);
    const T e = x - access.Load(args.truth + i);
    access.Store(args.out + i, SsimAdjoint(x, e, blurred.f[0], blurred.f[1], blurred.f[2]));
  };
  BlurRows<3, 3>(rows, products, kAsTheyAre, combine, kNothing);
}

}  // namespace VESTA_ISA
}  // namespace vesta
