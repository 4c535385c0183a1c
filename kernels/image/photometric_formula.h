// The formulas of the photometric loss for one pixel and channel, templates on the scalar.
//
// Notation: x rendered, y truth, e = x - y, u = x + y; G the Gaussian window, G f the weighted sum of f under it.
// Written in sums and differences, so that no quantity that is small when e is small is a difference of large numbers:
//   mx = (Gu + Ge)/2, my = (Gu - Ge)/2,  Var f = G f^2 - (G f)^2
//   D1 = mx^2 + my^2 + C1,  D2 = sx^2 + sy^2 + C2 = (Var u + Var e)/2 + C2,  l = (2 mx my + C1) / D1
//   1 - SSIM = (Ge)^2 / D1 + l Var(e) / D2      exactly, C1 = 0.01^2, C2 = 0.03^2 for colours in 0..1.
// In float, Var u carries an absolute error of some 1e-7 (Gu)^2, so D2 one of up to 1e-4 relative where a window is
// flat and bright, and 1 - SSIM and its derivatives the same relative error; Var e errs by 1e-7 of G e^2. Everything is
// finite for |x|, |y| up to 1e8.
//
// l is clamped at zero, derivative included; with images that are nowhere negative it never is.
#pragma once

#include "kernels/math/scalar.h"

namespace vesta {
inline namespace VESTA_ISA {

// 1 - SSIM of one window, and the parts its derivatives are made of.
template <class T>
struct SsimWindow {
  T mean_x, mean_error, variance_error;
  T inverse_d1, inverse_d2;
  T luminance;        // l
  T luminance_slope;  // dl by G dx

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
// (The pair x, e instead of x, y keeps q G(x dx) and s G(e dx) from cancelling where the images nearly agree.)
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

// d(1 - SSIM) from the blurred G(dx), G(x dx), G(e dx).
template <class T>
VESTA_HD inline T SsimTangent(const T& p, const T& q, const T& s, const T& blurred, const T& blurred_x,
                              const T& blurred_e) {
  return Fma(p, blurred, Fma(q, blurred_x, s * blurred_e));
}

// The transpose, pixel by pixel: from G(p v), G(q v), G(s v) to J^T v.
template <class T>
VESTA_HD inline T SsimAdjoint(const T& x, const T& e, const T& blurred_p, const T& blurred_q, const T& blurred_s) {
  return Fma(x, blurred_q, Fma(e, blurred_s, blurred_p));
}

// With D1, D2 and l frozen, 1 - SSIM is a quadratic in e with the Hessian diag(G s) + G diag(c) G, where s is the slope
// above and c this: 2 (1/D1 - l/D2).
template <class T>
VESTA_HD inline T SsimWindowCurvature(const SsimWindow<T>& w, const SsimSlopes<T>& slopes) {
  return w.inverse_d1 + w.inverse_d1 - slopes.s;
}

// Gauss-Newton on r = sqrt(d), d = 1 - SSIM, makes J^T diag(w) J of J = d(d)/dx: r^2 has the curvature 2 (J/2r)^T
// (J/2r). This is w = 1 / (2 d), where d is at least what a float can resolve of it.
template <class T>
VESTA_HD inline T SsimRootWeight(const T& dissimilarity) {
  const T floored = Max(dissimilarity, T(1e-6));
  return Reciprocal(floored + floored);
}

// Each score differentiated by its own pixel alone: d(1 - SSIM of the window) by its centre. centre: the window's
// weight there, squared for the two axes.
template <class T>
VESTA_HD inline T SsimCenterSlope(const T& centre, const T& x, const T& e, const SsimSlopes<T>& slopes) {
  return centre * SsimAdjoint(x, e, slopes.p, slopes.q, slopes.s);
}
// The contribution of that to the curvature of the root: ssim times its square times the weight.
template <class T>
VESTA_HD inline T SsimCenterCurvature(const T& ssim, const T& by_center, const T& dissimilarity) {
  return ssim * (by_center * by_center) * SsimRootWeight(dissimilarity);
}

// The terms of the diagonal of J^T diag(w) J in one window.
template <class T>
struct SsimRootProducts {
  T pp, qq, ss, pq, ps, qs;  // times w

  VESTA_HD SsimRootProducts(const T& w, const T& p, const T& q, const T& s) {
    const T wp = w * p, wq = w * q;
    pp = wp * p, qq = wq * q, ss = w * s * s;
    pq = wp * q, ps = wp * s, qs = wq * s;
  }
};

// The diagonal of J^T diag(w) J at a pixel, from G2 f for f = w p^2, w q^2, w s^2, w p q, w p s, w q s, G2 the window
// with its weights squared. Not negative.
template <class T>
VESTA_HD inline T SsimRootDiagonal(const T& x, const T& e, const T& pp, const T& qq, const T& ss, const T& pq,
                                   const T& ps, const T& qs) {
  const T mixed = Fma(x, pq, Fma(e, ps, x * e * qs));
  return Max(Fma(x * x, qq, Fma(e * e, ss, pp)) + (mixed + mixed), T(0));
}

}  // namespace VESTA_ISA
}  // namespace vesta
