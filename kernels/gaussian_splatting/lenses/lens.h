// SPDX-License-Identifier: Apache-2.0
// The lens of a camera as plain data, and the interface of a lens model (models.h).
#pragma once

#include <concepts>

#include "kernels/core/hd.h"
#include "kernels/math/scalar.h"

namespace vesta::splat {

// A lens model maps camera coordinates to an image plane, which the focal lengths (fx, fy) and the principal point (cx,
// cy) map to pixels. Pixel centres are at (i + 0.5, j + 0.5).
struct Lens {
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixels
  int model = 0;                          // index in LensModels (models.h); 0: the pinhole

  bool operator==(const Lens&) const = default;
  // The lens for a resized image. across, down: the factors of the image width and height.
  Lens Scaled(double across, double down) const { return {across * fx, down * fy, across * cx, down * cy, model}; }

  template <class Archive>
  void Visit(Archive& archive) {
    archive(fx, fy, cx, cy, model);
  }
};

inline namespace VESTA_ISA {

// Base class of all lens models.
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

  // Maps the image plane to pixels.
  template <class T>
  VESTA_HD void Pixel(const T& x, const T& y, T& u, T& v) const {
    u = Fma(T(fx), x, T(cx));
    v = Fma(T(fy), y, T(cy));
  }
};

// The interface of a lens model. t is a point in camera coordinates (x right, y down, z forward).
//
//   Plane     maps t to the image plane of focal length 1; NaN if the lens does not see t
//   PointAt   maps an image-plane point and a depth z back to a point
//   Project   computes the pixel of t, and the point (Point<T>) at which the derivative J of the pixel is evaluated;
//             for t far outside the image, this point is not t
//   IsInRange     whether J is evaluated at t itself
//   Adjoint   maps cotangents of the pixel and of products with J back to t: construct it from J, call Apply once per
//             product, then Finish
//   kName     the name in camera_model of transforms.json
//
// A model with Plane and PointAt gets the other members from DualLens (dual_lens.h).
template <class L>
concept LensModel = requires(const L lens, const float* t, float& u, float& v, float* out,
                             typename L::template Point<float>& at, typename L::template Adjoint<float>& adjoint) {
  *L::kName;
  L::Plane(t, u, v);
  L::PointAt(u, v, u, out);
  lens.Project(t, u, v, at);
  lens.Jacobian(t, at).Apply(u, t, u, v);
  { lens.IsInRange(t, at) } -> std::convertible_to<bool>;
  adjoint.Apply(u, t, u, v, u, v, out);
  adjoint.Finish(lens, t, u, v, out);
};

}  // namespace VESTA_ISA
}  // namespace vesta::splat
