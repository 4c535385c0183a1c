// SPDX-License-Identifier: Apache-2.0
// Calls each shared formula once, to compare host and device.
#pragma once

#include "kernels/gaussian_splatting/formulas/color.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/formulas/project.h"
#include "kernels/math/dual.h"

namespace vesta::splat {

inline constexpr int kDeviceMathOutputs = 68;

// x: mean, log-scale, quaternion and opacity logit of a Gaussian, as in layout.h. dx: a direction. out: projection,
// opacity, view direction and SH basis with their derivatives along dx; then the adjoint of the projection, a colour,
// and its adjoint by the mean.
template <class S>
VESTA_HD inline void EvaluateAll(const CameraConstants<S, Pinhole<S>>& camera, const S x[kGeometry],
                                 const S dx[kGeometry], S out[kDeviceMathOutputs]) {
  using D = Dual<S>;
  const auto put = [&out](const D& value) { *out++ = value.a, *out++ = value.v; };
  D dual[kGeometry];
  for (int i = 0; i < kGeometry; ++i) dual[i] = D(x[i], dx[i]);

  ProjectionState<Pinhole<S>, D> dual_state;
  const SplatShape<D> moved = Project(camera, dual + kMean, dual + kLogScale, dual + kQuaternion, dual_state);
  put(moved.u), put(moved.v), put(moved.r), put(moved.s), put(moved.beta), put(moved.compensation);
  put(Sigmoid(dual[kOpacity]));
  D dual_view[3], dual_basis[16];
  ViewDirection(camera.centre, dual + kMean, dual_view);
  for (const D& component : dual_view) put(component);
  ShBasis<3>(dual_view[0], dual_view[1], dual_view[2], dual_basis);
  for (const D& value : dual_basis) put(value);

  ProjectionState<Pinhole<S>, S> state;
  const SplatShape<S> shape = Project(camera, x + kMean, x + kLogScale, x + kQuaternion, state);
  const SplatShape<S> tangent = {moved.u.v, moved.v.v, moved.r.v, moved.s.v, moved.beta.v};
  S w[kSplatShape], log_scale_bar[3], quaternion_bar[4], mean_bar[3];
  WhitenTangent(shape, tangent, w);
  w[kLambda] = moved.compensation.v;
  ProjectAdjoint(camera, x + kQuaternion, state, shape, w, mean_bar, log_scale_bar, quaternion_bar);
  for (const S value : mean_bar) *out++ = value;
  for (const S value : log_scale_bar) *out++ = value;
  for (const S value : quaternion_bar) *out++ = value;

  S view[3], basis[16], color[3];
  const S inv_distance = ViewDirection(camera.centre, x + kMean, view);
  ShBasis<3>(view[0], view[1], view[2], basis);
  const auto sh = [dx](int a) { return dx[a % kGeometry]; };
  ShColor<3>(basis, sh, color);
  for (S& value : mean_bar) value = S(0);
  ShColorMeanAdjoint<3>(view, inv_distance, sh, color, mean_bar);
  for (const S value : color) *out++ = value;
  for (const S value : mean_bar) *out++ = value;
}

// Whether a GPU can run the device code of this program.
bool HasDevice();

// Returns CUDA's error message, or nullptr.
template <class S>
const char* EvaluateAllOnDevice(const CameraConstants<S, Pinhole<S>>& camera, const S* x, const S* dx, S* out);

}  // namespace vesta::splat
