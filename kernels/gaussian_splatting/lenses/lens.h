// SPDX-License-Identifier: Apache-2.0
// The lens of a camera as plain data, and what a lens model (models.h) has to give.
#pragma once

#include <concepts>

#include "kernels/core/hd.h"
#include "kernels/math/scalar.h"

namespace vesta::splat {

// The model maps points to an image plane; focal lengths and principal point map that plane to pixels, for all models.
// Pixel centres lie at (i + 0.5, j + 0.5).
struct Lens {
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixels
  int model = 0;                          // its place in LensModels (models.h); 0: the pinhole

  bool operator==(const Lens&) const = default;
  // The same lens before an image of other size: by these factors wider and higher.
  Lens Scaled(double across, double down) const { return {across * fx, down * fy, across * cx, down * cy, model}; }

  template <class Archive>
  void Visit(Archive& archive) {
    archive(fx, fy, cx, cy, model);
  }
};

inline namespace VESTA_ISA {

// The members that all models share, in the scalar S of the templates.
template <class S>
struct LensConstants {
  using Scalar = S;
  S fx, fy, cx, cy;

  LensConstants() = default;
  VESTA_HD explicit LensConstants(const Lens& lens)
      : fx(static_cast<S>(lens.fx)),
        fy(static_cast<S>(lens.fy)),
        cx(static_cast<S>(lens.cx)),
        cy(static_cast<S>(lens.cy)) {}

  // The pixel of a point of the image plane.
  template <class T>
  VESTA_HD void Pixel(const T& x, const T& y, T& u, T& v) const {
    u = Fma(T(fx), x, T(cx));
    v = Fma(T(fy), y, T(cy));
  }
};

// t: a point in camera coordinates (x right, y down, z forward). Plane maps it to the image plane of focal length 1,
// and PointAt maps back: to the point of depth z. NaN where the lens sees nothing. Project gives the pixel of t, and
// where the derivative J of the pixel by t is taken (Point<T>), which need not be at t where that is far outside the
// image; Shows says whether it is. Adjoint<T> carries cotangents of pixels and of products with J back to t; it is made
// of J, then come Apply once for each product, and Finish. A model that gives Plane and PointAt has the others from
// DualLens (dual_lens.h). kName: as camera_model of transforms.json has it.
template <class L>
concept LensModel = requires(const L lens, const float* t, float& u, float& v, float* out,
                             typename L::template Point<float>& at, typename L::template Adjoint<float>& adjoint) {
  *L::kName;
  L::Plane(t, u, v);
  L::PointAt(u, v, u, out);
  lens.Project(t, u, v, at);
  lens.Jacobian(t, at).Apply(u, t, u, v);
  { lens.Shows(t, at) } -> std::convertible_to<bool>;
  adjoint.Apply(u, t, u, v, u, v, out);
  adjoint.Finish(lens, t, u, v, out);
};

}  // namespace VESTA_ISA
}  // namespace vesta::splat
