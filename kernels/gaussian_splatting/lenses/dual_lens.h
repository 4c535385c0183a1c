// SPDX-License-Identifier: Apache-2.0
// Derivatives of a lens model by dual numbers (kernels/math/dual.h). A lens model M<S> derives from DualLens<M<S>, S>
// and defines only kName, Plane and PointAt (lens.h). Hand-written derivatives, as in pinhole.h, take a third of the
// time.
#pragma once

#include "kernels/gaussian_splatting/lenses/lens.h"
#include "kernels/math/dual.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

template <class M, class S>
struct DualLens : LensConstants<S> {
  DualLens() = default;
  VESTA_HD DualLens(const Lens& lens, int /*width*/, int /*height*/) : LensConstants<S>(lens) {}

  template <class T>
  struct Point {};
  template <class T>
  VESTA_HD void Project(const T t[3], T& u, T& v, Point<T>& /*at*/) const {
    T x, y;
    M::Plane(t, x, y);
    this->Pixel(x, y, u, v);
  }
  template <class T>
  VESTA_HD auto IsInRange(const T t[3], const Point<T>& /*at*/) const {
    return t[2] == t[2];
  }

  // Computes the pixel (u, v) of t, and its derivative along `direction`.
  template <class T>
  VESTA_HD void Along(const T t[3], const T direction[3], Dual<T>& u, Dual<T>& v) const {
    Point<Dual<T>> at;
    Dual<T> moved[3];
    for (int i = 0; i < 3; ++i) moved[i] = Dual<T>(t[i], direction[i]);
    Project(moved, u, v, at);
  }

  template <class T>
  struct Jacobian2x3 {
    DualLens lens;
    T t[3];

    VESTA_HD void Apply(const T& factor, const T a[3], T& m0, T& m1) const {
      Dual<T> u, v;
      lens.Along(t, a, u, v);
      m0 = factor * u.v, m1 = factor * v.v;
    }
  };
  template <class T>
  VESTA_HD Jacobian2x3<T> Jacobian(const T t[3], const Point<T>& /*at*/) const {
    return {*this, {t[0], t[1], t[2]}};
  }

  template <class T>
  struct Adjoint {
    Jacobian2x3<T> J;
    T products_bar[3];  // cotangent of t from all Apply calls

    VESTA_HD explicit Adjoint(const Jacobian2x3<T>& at) : J(at), products_bar{T(0), T(0), T(0)} {}
    VESTA_HD void Apply(const T& factor, const T a[3], const T& m0_bar, const T& m1_bar, const T& /*along0*/,
                        const T& /*along1*/, T a_bar[3]) {
      for (int i = 0; i < 3; ++i) {
        Dual<T> t[3], direction[3];
        for (int k = 0; k < 3; ++k) t[k] = Dual<T>(J.t[k], T(k == i ? 1.0f : 0.0f)), direction[k] = Dual<T>(a[k]);
        Dual<Dual<T>> u, v;
        J.lens.Along(t, direction, u, v);
        a_bar[i] = factor * (m0_bar * u.a.v + m1_bar * v.a.v);
        products_bar[i] = products_bar[i] + factor * (m0_bar * u.v.v + m1_bar * v.v.v);
      }
    }
    VESTA_HD void Finish(const DualLens& lens, const T t[3], const T& u_bar, const T& v_bar, T t_bar[3]) const {
      for (int i = 0; i < 3; ++i) {
        const T axis[3] = {T(i == 0 ? 1.0f : 0.0f), T(i == 1 ? 1.0f : 0.0f), T(i == 2 ? 1.0f : 0.0f)};
        Dual<T> u, v;
        lens.Along(t, axis, u, v);
        t_bar[i] = products_bar[i] + u_bar * u.v + v_bar * v.v;
      }
    }
  };
};

}  // namespace VESTA_ISA
}  // namespace vesta::splat
