// SPDX-License-Identifier: Apache-2.0
// Projection of one Gaussian to one view, and the adjoint, for any scalar (floats, SIMD batches, duals, Jets).
//
// First-order (EWA) projection as in 3DGS (Kerbl et al. 2023, eq. 5). The screen covariance is M M^T + h I with the 2 x
// 3 matrix M = J W R_q S. S contains the standard deviations, R_q is the rotation of the Gaussian's quaternion, W the
// rotation of the camera, J the derivative of the lens (lens.h), h the camera's 2D dilation eps2d. A name with _bar is
// a cotangent: the derivative of a scalar result with respect to that variable.
#pragma once

#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/lenses/models.h"
#include "kernels/math/quaternion.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// A camera with its pose, in scalar type S. L: the lens model.
template <class S, class L>
struct CameraConstants {
  S R[9], T[3], centre[3];
  L lens;
  S near;
  S eps2d, eps2d_squared;
  bool antialiased;
  S width, height;           // of the image
  S u_lo, u_hi, v_lo, v_hi;  // guard band (kGuardBand)
};

// Maximum distance of a projected mean from the image, in image widths and heights. The projection is linearised at the
// mean. Without this limit, a Gaussian beside the camera, with a small depth, would therefore cover the whole image
// like a veil. (Kerbl et al. 2023, section 6, use the same remedy.)
inline constexpr double kGuardBand = 2;

// Limit for Gaussians whose mean is more than 15 % of the image size outside the image: maximum standard deviation
// along the optical axis, divided by the depth of the mean. A longer Gaussian would extend beside the camera, where the
// linear projection creates veils and streaks (docs/decisions/projection-limits.md).
inline constexpr double kDepthSpread = 0.5;

// Maximum determinant of a screen covariance, pixels^4. The derivative of a larger determinant overflows float.
inline constexpr double kLargestDet = 1e34;

// The square is computed in double before it is rounded to S.
template <class S, class L>
inline void SetEps2d(double variance, CameraConstants<S, L>& c) {
  c.eps2d = static_cast<S>(variance), c.eps2d_squared = static_cast<S>(variance * variance);
}

// L: the lens model.
template <class L, class S = typename L::Scalar>
inline CameraConstants<S, L> ConstantsOf(const PosedCamera& camera) {
  CameraConstants<S, L> c;
  for (int i = 0; i < 9; ++i) c.R[i] = static_cast<S>(camera.R[i]);
  for (int i = 0; i < 3; ++i) c.T[i] = static_cast<S>(camera.T[i]);
  for (int i = 0; i < 3; ++i) c.centre[i] = static_cast<S>(camera.centre[i]);
  c.lens = L(camera.lens, camera.width, camera.height);
  c.near = static_cast<S>(camera.near);
  SetEps2d(camera.eps2d, c);
  c.antialiased = camera.antialiased;
  c.u_lo = static_cast<S>(-kGuardBand * camera.width), c.u_hi = static_cast<S>((1 + kGuardBand) * camera.width);
  c.v_lo = static_cast<S>(-kGuardBand * camera.height), c.v_hi = static_cast<S>((1 + kGuardBand) * camera.height);
  c.width = static_cast<S>(camera.width), c.height = static_cast<S>(camera.height);
  return c;
}

// Calls body with the CameraConstants for the camera's lens model.
template <class S, class Body>
inline decltype(auto) WithConstants(const PosedCamera& camera, const Body& body) {
  return OfModel<S>(LensModels(), camera.lens.model,
                    [&](auto model) { return body(ConstantsOf<typename decltype(model)::type>(camera)); });
}

// Intermediate results for the adjoint.
template <class L, class T>
struct ProjectionState {
  T t[3];                            // camera coordinates
  typename L::template Point<T> at;  // where the derivative of the lens is evaluated
  T A[9];                            // W R_q
  T scale[3];                        // standard deviations
  T M0[3], M1[3];                    // rows of M
  T B, C, det;                       // screen covariance: xy, yy, determinant
  // In antialiased views: the determinant without the 2D dilation, and the difference of the two.
  T det_undilated, det_of_dilation;
};

// Mean and shape of a splat in whitened form: u, v, r, s, beta of Splat (types.h).
//
// compensation is the factor of the opacity in antialiased views, and 1 in others. The 2D dilation enlarges a splat by
// sqrt(det) / sqrt(det_undilated); this factor keeps its integral over the image (Yu et al. 2024, Mip-Splatting, eq.
// 10, with the dilation as the filter; gsplat calls it antialiased).
template <class T>
struct SplatShape {
  T u, v, r, s, beta;
  T compensation = T(1);
};

// S is the scalar type of the camera's constants. For depths z <= 0, the result may be infinite or NaN. The caller must
// discard it.
template <class S, class L, class T>
VESTA_HD inline SplatShape<T> Project(const CameraConstants<S, L>& camera, const T mean[3], const T log_scale[3],
                                      const T quaternion[4], ProjectionState<L, T>& state) {
  using std::sqrt;
  T R[9];
  RotationFromQuaternion(quaternion, R);
  for (int i = 0; i < 3; ++i) {
    const T W0(camera.R[3 * i]), W1(camera.R[3 * i + 1]), W2(camera.R[3 * i + 2]);
    state.t[i] = Fma(W0, mean[0], Fma(W1, mean[1], Fma(W2, mean[2], T(camera.T[i]))));
    for (int k = 0; k < 3; ++k) state.A[3 * i + k] = Fma(W0, R[k], Fma(W1, R[3 + k], W2 * R[6 + k]));
    state.scale[i] = Exp(log_scale[i]);
  }
  SplatShape<T> shape;
  camera.lens.Project(state.t, shape.u, shape.v, state.at);
  const auto J = camera.lens.Jacobian(state.t, state.at);
  for (int k = 0; k < 3; ++k) {
    const T axis[3] = {state.A[k], state.A[3 + k], state.A[6 + k]};
    J.Apply(state.scale[k], axis, state.M0[k], state.M1[k]);
  }
  const T *m = state.M0, *n = state.M1;
  const T c0 = m[1] * n[2] - m[2] * n[1], c1 = m[2] * n[0] - m[0] * n[2], c2 = m[0] * n[1] - m[1] * n[0];
  const T mm = Fma(m[0], m[0], Fma(m[1], m[1], m[2] * m[2]));
  const T nn = Fma(n[0], n[0], Fma(n[1], n[1], n[2] * n[2]));
  const T eps2d(camera.eps2d);
  state.B = Fma(m[0], n[0], Fma(m[1], n[1], m[2] * n[2]));
  state.C = nn + eps2d;
  // |m x n|^2 + h (|m|^2 + |n|^2) + h^2, a sum of positive terms. In float A C - B^2 would lose all digits for very
  // elongated Gaussians.
  state.det = Fma(c0, c0, Fma(c1, c1, Fma(c2, c2, Fma(eps2d, mm + nn, T(camera.eps2d_squared)))));
  if (camera.antialiased) {
    state.det_undilated = Fma(c0, c0, Fma(c1, c1, c2 * c2));
    state.det_of_dilation = Fma(eps2d, mm + nn, T(camera.eps2d_squared));
    // sqrt(det_undilated / det), in a form whose derivative does not cancel for large Gaussians.
    shape.compensation = T(1) / sqrt(T(1) + state.det_of_dilation / state.det_undilated);
  }
  shape.r = T(kWhitening) * sqrt(state.C / state.det);
  shape.s = T(kWhitening) / sqrt(state.C);
  shape.beta = -state.B / state.C;
  return shape;
}

// Whether the linear projection is accurate enough for the Gaussian (kDepthSpread).
template <class L, class T>
VESTA_HD inline auto IsProjectionAccurate(const L& lens, const ProjectionState<L, T>& state) {
  T variance(0);
  for (int k = 0; k < 3; ++k) {
    const T along = state.scale[k] * state.A[6 + k];
    variance = Fma(along, along, variance);
  }
  const T limit = T(kDepthSpread) * state.t[2];
  return lens.IsInRange(state.t, state.at) | (variance <= limit * limit);
}

// Converts a derivative d of the shape to the first five components of a splat tangent (SplatTangent in types.h).
template <class T>
VESTA_HD inline void WhitenTangent(const SplatShape<T>& shape, const SplatShape<T>& d, T w[kLambda]) {
  const T two_ln2(kTwoLn2);
  w[kXi] = -two_ln2 * shape.r * Fma(shape.beta, d.v, d.u);
  w[kZeta] = -two_ln2 * shape.s * d.v;
  w[kRho] = two_ln2 * d.r / shape.r;
  w[kKappa] = two_ln2 * shape.r / shape.s * d.beta;
  w[kSigma] = two_ln2 * d.s / shape.s;
}

// Computes the cotangent of the projected mean (u, v) from w_bar, the splat's cotangent.
template <class T>
VESTA_HD inline void ScreenMeanAdjoint(const T& r, const T& s, const T& beta, const T* w_bar, T& u_bar, T& v_bar) {
  const T two_ln2(kTwoLn2);
  u_bar = -two_ln2 * r * w_bar[kXi];
  v_bar = Fma(beta, u_bar, -two_ln2 * s * w_bar[kZeta]);
}

// Adjoint of Project followed by WhitenTangent: computes mean_bar[3], log_scale_bar[3] and quaternion_bar[4] from the
// components w_bar[0], ..., w_bar[4], and in an antialiased view also from w_bar[kLambda], because the compensation
// depends on the shape. state, shape: from Project.
template <class S, class L, class T>
VESTA_HD inline void ProjectAdjoint(const CameraConstants<S, L>& camera, const T quaternion[4],
                                    const ProjectionState<L, T>& state, const SplatShape<T>& shape, const T* w_bar,
                                    T mean_bar[3], T log_scale_bar[3], T quaternion_bar[4]) {
  using std::sqrt;
  const T two_ln2(kTwoLn2), rho_bar = two_ln2 * w_bar[kRho], sigma_bar = two_ln2 * w_bar[kSigma];
  T u_bar, v_bar;
  ScreenMeanAdjoint(shape.r, shape.s, shape.beta, w_bar, u_bar, v_bar);
  // log r = (log C - log det) / 2, log s = -log C / 2, (r / s) d beta = (-dB + (B / C) dC) / sqrt(det)
  const T kappa = two_ln2 * w_bar[kKappa] / sqrt(state.det);
  const T B_bar = -kappa;
  const T C_bar = (T(0.5f) * (rho_bar - sigma_bar) + kappa * state.B) / state.C;
  const T det_bar = T(-0.5f) * rho_bar / state.det;
  T dilation_bar(0), product_bar(0);  // twice the cotangents of det_of_dilation and det_undilated in the compensation
  if (camera.antialiased) {           // log compensation = -log(1 + det_of_dilation / det_undilated) / 2
    dilation_bar = -w_bar[kLambda] / state.det;
    product_bar = -dilation_bar * (state.det_of_dilation / state.det_undilated);
    dilation_bar = dilation_bar * T(camera.eps2d);
  }

  const T *m = state.M0, *n = state.M1;
  const T c[3] = {m[1] * n[2] - m[2] * n[1], m[2] * n[0] - m[0] * n[2], m[0] * n[1] - m[1] * n[0]};
  const T two_det = T(2) * det_bar, eps2d(camera.eps2d);
  typename L::template Adjoint<T> adjoint(camera.lens.Jacobian(state.t, state.at));
  T A_bar[9];
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const T cross0 = n[i] * c[j] - n[j] * c[i], cross1 = c[i] * m[j] - c[j] * m[i];  // of d |m x n|^2 / 2
    T M0_bar = Fma(two_det, cross0 + eps2d * m[k], B_bar * n[k]);
    T M1_bar = Fma(two_det, cross1 + eps2d * n[k], Fma(B_bar, m[k], T(2) * C_bar * n[k]));
    if (camera.antialiased) {
      M0_bar = Fma(product_bar, cross0, Fma(dilation_bar, m[k], M0_bar));
      M1_bar = Fma(product_bar, cross1, Fma(dilation_bar, n[k], M1_bar));
    }
    const T along0 = M0_bar * m[k], along1 = M1_bar * n[k];
    log_scale_bar[k] = along0 + along1;
    const T axis[3] = {state.A[k], state.A[3 + k], state.A[6 + k]};
    T axis_bar[3];
    adjoint.Apply(state.scale[k], axis, M0_bar, M1_bar, along0, along1, axis_bar);
    for (int row = 0; row < 3; ++row) A_bar[3 * row + k] = axis_bar[row];
  }
  T t_bar[3];
  adjoint.Finish(camera.lens, state.t, u_bar, v_bar, t_bar);
  T R_bar[9];
  for (int i = 0; i < 3; ++i) {
    const T W0(camera.R[i]), W1(camera.R[3 + i]), W2(camera.R[6 + i]);
    mean_bar[i] = Fma(W0, t_bar[0], Fma(W1, t_bar[1], W2 * t_bar[2]));
    for (int k = 0; k < 3; ++k) R_bar[3 * i + k] = Fma(W0, A_bar[k], Fma(W1, A_bar[3 + k], W2 * A_bar[6 + k]));
  }
  RotationFromQuaternionAdjoint(quaternion, R_bar, quaternion_bar);
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
