// SPDX-License-Identifier: Apache-2.0
// The formulas of the photometric loss for one pixel and channel, as templates on the scalar.
//
// Notation: x rendered, y truth, e = x - y, u = x + y. G f is the sum of f weighted by the Gaussian window G. mx, my
// are the means of x and y in a window, sx^2, sy^2 their variances. l is the luminance factor of SSIM. With u and e,
// any quantity that is small for small e is computed without a difference of large numbers:
//   mx = (Gu + Ge)/2, my = (Gu - Ge)/2,  Var f = G f^2 - (G f)^2
//   D1 = mx^2 + my^2 + C1,  D2 = sx^2 + sy^2 + C2 = (Var u + Var e)/2 + C2,  l = (2 mx my + C1) / D1
//   1 - SSIM = (Ge)^2 / D1 + l Var(e) / D2      exactly, C1 = 0.01^2, C2 = 0.03^2 for colours in 0..1.
// In float, Var u has an absolute error of about 1e-7 (Gu)^2. For a flat and bright window, the relative error of D2, 1
// - SSIM and the derivatives is then up to 1e-4. The absolute error of Var e is 1e-7 G e^2. All results are finite for
// |x|, |y| up to 1e8.
//
// l and its derivative are clamped at zero. Without negative values l is never clamped.
#pragma once

#include "kernels/math/scalar.h"

namespace vesta {
inline namespace VESTA_ISA {

// 1 - SSIM of one window, and the terms of its derivatives.
template <class T>
struct SsimWindow {
  T mean_x, mean_error, variance_error;
  T inverse_d1, inverse_d2;
  T luminance;        // l
  T luminance_slope;  // derivative of l with respect to Gx

  // From G u, G e, G u^2, G e^2.
  VESTA_HD SsimWindow(const T& sum, const T& error, const T& sum_squared, const T& error_squared) {
    const T half(0.5), c1(1e-4), c2(9e-4), zero(0);
    const T half_sum = half * sum, half_error = half * error;
    mean_x = half_sum + half_error;
    const T mean_y = half_sum - half_error;
    mean_error = error;
    variance_error = Max(Fnma(error, error, error_squared), zero);
    const T variance_sum = Max(Fnma(sum, sum, sum_squared), zero);
    inverse_d1 = Reciprocal(Fma(half_sum, sum, Fma(half_error, error, c1)));
    inverse_d2 = Reciprocal(Fma(half, variance_sum + variance_error, c2));
    const T covariance_of_means = Fma(mean_x + mean_x, mean_y, c1);
    luminance = Max(covariance_of_means * inverse_d1, zero);
    const T slope = Fnma(luminance, mean_x, mean_y) * inverse_d1;
    luminance_slope = Select(covariance_of_means < zero, zero, slope + slope);
  }

  // 1 - SSIM, at least 0.
  VESTA_HD T Dissimilarity() const {
    return Fma(mean_error, mean_error * inverse_d1, luminance * (variance_error * inverse_d2));
  }
};

// The derivative of 1 - SSIM of one window is linear in three blurred fields:
//   d(1 - SSIM) = p G(dx) + q G(x dx) + s G(e dx).
// (The pair x, y instead of x, e would let the last two terms cancel where the images nearly agree.)
template <class T>
struct SsimSlopes {
  T p, q, s;

  VESTA_HD explicit SsimSlopes(const SsimWindow<T>& w) {
    const T contrast = w.variance_error * w.inverse_d2;
    const T mean_scaled = w.mean_error * w.inverse_d1;
    s = (w.luminance + w.luminance) * w.inverse_d2;
    q = -(s * contrast);
    const T by_mean = Fma(mean_scaled + mean_scaled, Fnma(mean_scaled, w.mean_x, T(1)), contrast * w.luminance_slope);
    p = Fnma(q, w.mean_x, Fnma(s, w.mean_error, by_mean));
  }
};

// The transpose for one pixel: returns J^T v from G(p v), G(q v) and G(s v).
template <class T>
VESTA_HD inline T SsimAdjoint(const T& x, const T& e, const T& blurred_p, const T& blurred_q, const T& blurred_s) {
  return Fma(x, blurred_q, Fma(e, blurred_s, blurred_p));
}

// With D1, D2 and l constant, 1 - SSIM is a quadratic in e with the Hessian diag(G s) + G diag(c) G. s is the slope of
// SsimSlopes. Returns c = 2 (1/D1 - l/D2), the window curvature.
template <class T>
VESTA_HD inline T SsimWindowCurvature(const SsimWindow<T>& w, const SsimSlopes<T>& slopes) {
  return w.inverse_d1 + w.inverse_d1 - slopes.s;
}

// Gauss-Newton on r = sqrt(d), d = 1 - SSIM, has the curvature 2 (j/2r)^2 = w j^2, with j = d(d)/dx. Returns w = 1 / (2
// d), with d at least 1e-6, the accuracy of float.
template <class T>
VESTA_HD inline T SsimRootWeight(const T& dissimilarity) {
  const T floored = Max(dissimilarity, T(1e-6));
  return Reciprocal(floored + floored);
}

// Derivative of 1 - SSIM of a window with respect to its centre pixel. centre: weight of the centre pixel, the square
// of the centre tap.
template <class T>
VESTA_HD inline T SsimCenterSlope(const T& centre, const T& x, const T& e, const SsimSlopes<T>& slopes) {
  return centre * SsimAdjoint(x, e, slopes.p, slopes.q, slopes.s);
}
// Curvature of Gauss-Newton on the root, for the centre pixel: ssim * derivative^2 * SsimRootWeight. by_center: from
// SsimCenterSlope.
template <class T>
VESTA_HD inline T SsimCenterCurvature(const T& ssim, const T& by_center, const T& dissimilarity) {
  return ssim * (by_center * by_center) * SsimRootWeight(dissimilarity);
}

}  // namespace VESTA_ISA
}  // namespace vesta
