// SPDX-License-Identifier: Apache-2.0
// Derivatives of a splat with respect to the lens of its view.
//
// A change of the focal length scales the projected mean about the principal point, and the screen covariance without
// the 2D dilation, and in antialiased views it changes the opacity. Colours and depths do not change. The derivative
// therefore depends only on the splat. For Gaussians
// far outside the image, the projection uses the derivative of the lens at a clamped point (IsInRange in lens.h). Here,
// this point is treated as constant.
#pragma once

#include "kernels/gaussian_splatting/formulas/project.h"
#include "kernels/gaussian_splatting/formulas/types.h"

namespace vesta::splat {

// A tangent or cotangent of a lens. The parameters are the logarithms of the focal lengths, then the principal point
// divided by the focal lengths. Changes of these parameters do not depend on the image size.
inline constexpr int kLensTangent = 4;
struct LensTangent {
  double v[kLensTangent] = {};  // log fx, log fy, cx / fx, cy / fy

  LensTangent& operator+=(const LensTangent& other) {
    for (int k = 0; k < kLensTangent; ++k) v[k] += other.v[k];
    return *this;
  }
};

// Derivatives of a splat with respect to the lens. w[k]: the first kSplatShape components of the splat tangent
// (SplatTangent in types.h) for a unit change of lens parameter k. The other components are zero.
struct LensRows {
  double w[kLensTangent][kSplatShape] = {};

  template <class S>
  VESTA_HD LensRows(const Splat<S>& splat, const PosedCamera& camera) {
    const Lens& lens = camera.lens;
    const SplatShape<double> shape = {double(splat.u), double(splat.v), double(splat.r), double(splat.s),
                                      double(splat.beta)};
    // The screen covariance [A B; B C], computed from r, s and beta (types.h).
    const double C = kWhitening * kWhitening / (shape.s * shape.s), B = -shape.beta * C;
    const double det_by_C = kWhitening * kWhitening / (shape.r * shape.r), det = det_by_C * C, A = det_by_C + B * B / C;
    const auto set = [&](int k, double du, double dv, double dA, double dB, double dC) {
      const double d_det = dA * C + A * dC - 2 * B * dB;
      const SplatShape<double> d = {du, dv, shape.r * (dC / C - d_det / det) / 2, -shape.s * dC / (2 * C),
                                    (B * dC / C - dB) / C};
      WhitenTangent(shape, d, w[k]);
      return d_det / det;
    };
    // A focal length scales the determinant without the dilation by its square.
    const double fx = set(0, shape.u - lens.cx, 0, 2 * (A - camera.eps2d), B, 0);
    const double fy = set(1, 0, shape.v - lens.cy, 0, B, 2 * (C - camera.eps2d));
    if (camera.antialiased) w[0][kLambda] = 1 - fx / 2, w[1][kLambda] = 1 - fy / 2;
    set(2, lens.fx, 0, 0, 0, 0);
    set(3, 0, lens.fy, 0, 0, 0);
  }

  // The splat's change for a change delta of the lens.
  template <class S>
  VESTA_HD SplatTangent<S> Tangent(const LensTangent& delta) const {
    SplatTangent<S> tangent = {};
    for (int i = 0; i < kSplatShape; ++i) {
      double sum = 0;
      for (int k = 0; k < kLensTangent; ++k) sum += w[k][i] * delta.v[k];
      tangent.w[i] = static_cast<S>(sum);
    }
    return tangent;
  }
  // Adds the adjoint of Tangent to sum[kLensTangent].
  template <class S>
  VESTA_HD void AddCotangent(const SplatTangent<S>& cotangent, double* sum) const {
    for (int k = 0; k < kLensTangent; ++k) {
      for (int i = 0; i < kSplatShape; ++i) sum[k] += w[k][i] * static_cast<double>(cotangent.w[i]);
    }
  }
};

}  // namespace vesta::splat
