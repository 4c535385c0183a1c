// SPDX-License-Identifier: Apache-2.0
// The pinhole, a lens (lens.h): pixel = f (x / z, y / z) + c.
#pragma once

#include "kernels/core/hd.h"
#include "kernels/math/scalar.h"

namespace vesta::splat {

// Focal lengths and principal point, pixels. Pixel centres lie at (i + 0.5, j + 0.5).
struct Pinhole {
  double fx = 0, fy = 0, cx = 0, cy = 0;

  bool operator==(const Pinhole&) const = default;
  // The same lens before an image of other size: by these factors wider and higher.
  Pinhole Scaled(double across, double down) const { return {across * fx, down * fy, across * cx, down * cy}; }

  template <class Archive>
  void Visit(Archive& archive) {
    archive(fx, fy, cx, cy);
  }
};

inline namespace VESTA_ISA {

template <class S, class T>
VESTA_HD inline void PinholePixel(const S& lens, const T& x_over_z, const T& y_over_z, T& u, T& v) {
  u = Fma(T(lens.fx), x_over_z, T(lens.cx));
  v = Fma(T(lens.fy), y_over_z, T(lens.cy));
}
// The pixel of t in camera coordinates, z > 0.
VESTA_HD inline void PixelOf(const Pinhole& lens, const double t[3], double& u, double& v) {
  PinholePixel(lens, t[0] / t[2], t[1] / t[2], u, v);
}

// What the projection's derivative was taken at: x/z and y/z, clamped.
template <class T>
struct PinholePoint {
  T tx, ty;
};

// The 2 x 3 derivative J of the pixel by camera coordinates, at such a point.
template <class T>
struct PinholeJacobian {
  T jx, jy, tx, ty;

  // (m0, m1) = J (factor a).
  VESTA_HD void Apply(const T& factor, const T a[3], T& m0, T& m1) const {
    m0 = jx * factor * (a[0] - tx * a[2]);
    m1 = jy * factor * (a[1] - ty * a[2]);
  }
};

// The adjoint of the pixel and of products with J: first Apply for each product, then Finish.
template <class T>
struct PinholeAdjoint {
  PinholeJacobian<T> J;
  T tx_bar, ty_bar, z_sum;

  VESTA_HD explicit PinholeAdjoint(const PinholeJacobian<T>& at) : J(at), tx_bar(0), ty_bar(0), z_sum(0) {}

  // Of J.Apply(factor, a, m0, m1): a_bar (overwritten). along0 = m0_bar m0 and along1 = m1_bar m1.
  VESTA_HD void Apply(const T& factor, const T a[3], const T& m0_bar, const T& m1_bar, const T& along0, const T& along1,
                      T a_bar[3]) {
    z_sum = z_sum + along0 + along1;
    a_bar[0] = m0_bar * J.jx * factor;
    a_bar[1] = m1_bar * J.jy * factor;
    a_bar[2] = -(J.tx * a_bar[0] + J.ty * a_bar[1]);
    tx_bar = tx_bar - a_bar[0] * a[2];
    ty_bar = ty_bar - a_bar[1] * a[2];
  }

  // t_bar[3] (overwritten) from all that was applied and from the cotangent of the pixel.
  template <class Lens>
  VESTA_HD void Finish(const Lens& lens, const T t[3], const T& u_bar, const T& v_bar, T t_bar[3]) const {
    const T inv_z = T(1) / t[2];
    const T x = t[0] * inv_z, y = t[1] * inv_z;
    // The clamp passes its derivative on inside and on its border, as Clamp of a Dual does; beyond, tx is constant.
    const T x_clamped = Select(x >= T(lens.x_lo), Select(x <= T(lens.x_hi), tx_bar, T(0)), T(0));
    const T y_clamped = Select(y >= T(lens.y_lo), Select(y <= T(lens.y_hi), ty_bar, T(0)), T(0));
    t_bar[0] = Fma(T(lens.fx), u_bar, x_clamped) * inv_z;
    t_bar[1] = Fma(T(lens.fy), v_bar, y_clamped) * inv_z;
    t_bar[2] = -(t_bar[0] * x + t_bar[1] * y + z_sum * inv_z);
  }
};

// A Pinhole with constants in the scalar S of the templates.
template <class S>
struct PinholeLens {
  template <class T>
  using Point = PinholePoint<T>;
  template <class T>
  using Adjoint = PinholeAdjoint<T>;

  S fx, fy, cx, cy;
  S x_lo, x_hi, y_lo, y_hi;  // clamp of x/z and y/z inside J: 15 % of the image beyond its borders

  PinholeLens() = default;
  VESTA_HD PinholeLens(const Pinhole& lens, int width, int height)
      : fx(static_cast<S>(lens.fx)),
        fy(static_cast<S>(lens.fy)),
        cx(static_cast<S>(lens.cx)),
        cy(static_cast<S>(lens.cy)),
        x_lo(static_cast<S>((-lens.cx - 0.15 * width) / lens.fx)),
        x_hi(static_cast<S>((1.15 * width - lens.cx) / lens.fx)),
        y_lo(static_cast<S>((-lens.cy - 0.15 * height) / lens.fy)),
        y_hi(static_cast<S>((1.15 * height - lens.cy) / lens.fy)) {}

  // The pixel of t in camera coordinates, and where J is taken.
  template <class T>
  VESTA_HD void Project(const T t[3], T& u, T& v, Point<T>& at) const {
    const T inv_z = T(1) / t[2];
    const T x = t[0] * inv_z, y = t[1] * inv_z;
    at.tx = Clamp(x, T(x_lo), T(x_hi));
    at.ty = Clamp(y, T(y_lo), T(y_hi));
    PinholePixel(*this, x, y, u, v);
  }
  template <class T>
  VESTA_HD PinholeJacobian<T> Jacobian(const T t[3], const Point<T>& at) const {
    const T inv_z = T(1) / t[2];
    return {T(fx) * inv_z, T(fy) * inv_z, at.tx, at.ty};
  }
  // Whether J was taken at t itself, not at the border of what the lens shows.
  template <class T>
  VESTA_HD auto Shows(const T t[3], const Point<T>& at) const {
    const T inv_z = T(1) / t[2];
    return (t[0] * inv_z == at.tx) & (t[1] * inv_z == at.ty);
  }
};

}  // namespace VESTA_ISA
}  // namespace vesta::splat
