// SPDX-License-Identifier: Apache-2.0
// The lens of the cameras: what projection needs to know of how directions become pixels. A lens model is one file,
// as pinhole.h is: plain data, and the same with constants in the scalar of the templates (LensModel).
#pragma once

#include <concepts>

#include "kernels/gaussian_splatting/formulas/pinhole.h"

namespace vesta::splat {

// Of all cameras of a program. A second model is named here; a choice at run time begins with ProjectKernels of each.
using Lens = Pinhole;

inline namespace VESTA_ISA {

template <class S>
using LensIn = PinholeLens<S>;

// t: a point in camera coordinates (x right, y down, z forward). Point<T>: where on the lens the derivative J of the
// pixel by t is taken, which need not be at t where that is far outside the image. Adjoint<T> carries cotangents of
// pixels and of products with J back to t; it is made of J, then come Apply once for each product, and Finish.
template <class L>
concept LensModel = requires(const L lens, const float* t, float& u, float& v, float* a_bar,
                             typename L::template Point<float>& at, typename L::template Adjoint<float>& adjoint) {
  lens.Project(t, u, v, at);
  lens.Jacobian(t, at).Apply(u, t, u, v);
  { lens.Shows(t, at) } -> std::convertible_to<bool>;
  adjoint.Apply(u, t, u, v, u, v, a_bar);
  adjoint.Finish(lens, t, u, v, a_bar);
};
static_assert(LensModel<LensIn<float>>);
static_assert(requires(const Lens lens, double* t) {
  PixelOf(lens, t, *t, *t);
  lens.Scaled(0.5, 0.5);
});

}  // namespace VESTA_ISA
}  // namespace vesta::splat
