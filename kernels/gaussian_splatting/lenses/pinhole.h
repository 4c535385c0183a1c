// SPDX-License-Identifier: Apache-2.0
// The pinhole lens model (lens.h): image-plane coordinates (x / z, y / z). Every training uses this model, so its
// derivatives are written by hand.
#pragma once

#include "kernels/gaussian_splatting/lenses/lens.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

template <class S>
struct Pinhole : LensConstants<S> {
  static constexpr const char* kName = "PINHOLE";
  using LensConstants<S>::fx, LensConstants<S>::fy;

  S x_lo, x_hi, y_lo, y_hi;  // limits of x/z and y/z at which J is evaluated: 15 % of the image size outside the image

  Pinhole() = default;
  VESTA_HD Pinhole(const Lens& lens, int width, int height)
      : LensConstants<S>(lens),
        x_lo(static_cast<S>((-lens.cx - 0.15 * width) / lens.fx)),
        x_hi(static_cast<S>((1.15 * width - lens.cx) / lens.fx)),
        y_lo(static_cast<S>((-lens.cy - 0.15 * height) / lens.fy)),
        y_hi(static_cast<S>((1.15 * height - lens.cy) / lens.fy)) {}

  template <class T>
  VESTA_HD static void Plane(const T t[3], T& x, T& y) {
    const T inv_z = T(1) / t[2];
    x = t[0] * inv_z, y = t[1] * inv_z;
  }
  template <class T>
  VESTA_HD static void PointAt(const T& x, const T& y, const T& z, T t[3]) {
    t[0] = z * x, t[1] = z * y, t[2] = z;
  }

  // x/z and y/z, clamped to these limits.
  template <class T>
  struct Point {
    T tx, ty;
  };
  template <class T>
  VESTA_HD void Project(const T t[3], T& u, T& v, Point<T>& at) const {
    T x, y;
    Plane(t, x, y);
    at.tx = Clamp(x, T(x_lo), T(x_hi));
    at.ty = Clamp(y, T(y_lo), T(y_hi));
    this->Pixel(x, y, u, v);
  }
  template <class T>
  VESTA_HD auto IsInRange(const T t[3], const Point<T>& at) const {
    T x, y;
    Plane(t, x, y);
    return (x == at.tx) & (y == at.ty);
  }

  template <class T>
  struct Jacobian2x3 {
    T jx, jy, tx, ty;

    // (m0, m1) = J (factor a).
    VESTA_HD void Apply(const T& factor, const T a[3], T& m0, T& m1) const {
      m0 = jx * factor * (a[0] - tx * a[2]);
      m1 = jy * factor * (a[1] - ty * a[2]);
    }
  };
  template <class T>
  VESTA_HD Jacobian2x3<T> Jacobian(const T t[3], const Point<T>& at) const {
    const T inv_z = T(1) / t[2];
    return {T(fx) * inv_z, T(fy) * inv_z, at.tx, at.ty};
  }

  template <class T>
  struct Adjoint {
    Jacobian2x3<T> J;
    T tx_bar, ty_bar, z_sum;

    VESTA_HD explicit Adjoint(const Jacobian2x3<T>& at) : J(at), tx_bar(0), ty_bar(0), z_sum(0) {}

    // Adjoint of J.Apply(factor, a, m0, m1): computes a_bar. along0 must be m0_bar m0, and along1 m1_bar m1.
    VESTA_HD void Apply(const T& factor, const T a[3], const T& m0_bar, const T& m1_bar, const T& along0,
                        const T& along1, T a_bar[3]) {
      z_sum = z_sum + along0 + along1;
      a_bar[0] = m0_bar * J.jx * factor;
      a_bar[1] = m1_bar * J.jy * factor;
      a_bar[2] = -(J.tx * a_bar[0] + J.ty * a_bar[1]);
      tx_bar = tx_bar - a_bar[0] * a[2];
      ty_bar = ty_bar - a_bar[1] * a[2];
    }

    // Computes t_bar[3] from all Apply calls and (u_bar, v_bar), the cotangent of the pixel.
    VESTA_HD void Finish(const Pinhole& lens, const T t[3], const T& u_bar, const T& v_bar, T t_bar[3]) const {
      const T inv_z = T(1) / t[2];
      const T x = t[0] * inv_z, y = t[1] * inv_z;
      // tx and ty depend on t inside the limits and at the limits, as with Clamp of a Dual. Outside, they are constant.
      const T x_clamped = Select(x >= T(lens.x_lo), Select(x <= T(lens.x_hi), tx_bar, T(0)), T(0));
      const T y_clamped = Select(y >= T(lens.y_lo), Select(y <= T(lens.y_hi), ty_bar, T(0)), T(0));
      t_bar[0] = Fma(T(lens.fx), u_bar, x_clamped) * inv_z;
      t_bar[1] = Fma(T(lens.fy), v_bar, y_clamped) * inv_z;
      t_bar[2] = -(t_bar[0] * x + t_bar[1] * y + z_sum * inv_z);
    }
  };
};

}  // namespace VESTA_ISA
}  // namespace vesta::splat
