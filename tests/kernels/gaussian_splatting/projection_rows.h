// SPDX-License-Identifier: Apache-2.0
// The derivative K of a splat's whitened shape by its parameters, by Jets and by the adjoint.
#pragma once

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/formulas/project.h"

namespace vesta::splat {

inline constexpr int kParameters = 10;  // mean, log-scale, quaternion
using Jet = ceres::Jet<double, kParameters>;

// The first kSplatShape components of the splat tangent, from a shape in Jets or duals. derivative(x): the derivative
// of x that is meant.
template <class J, class Derivative>
void TangentOf(const SplatShape<J>& shape, const Derivative& derivative, double w[kSplatShape]) {
  WhitenTangent<double>(
      {shape.u.a, shape.v.a, shape.r.a, shape.s.a, shape.beta.a},
      {derivative(shape.u), derivative(shape.v), derivative(shape.r), derivative(shape.s), derivative(shape.beta)}, w);
  w[kLambda] = derivative(shape.compensation) / shape.compensation.a;
}

// Through Project and WhitenTangent; rows are the entries of the splat tangent.
template <class L>
void JetRows(const CameraConstants<double, L>& camera, const double* p, double K[kSplatShape][kParameters]) {
  Jet jets[kParameters];
  for (int i = 0; i < kParameters; ++i) jets[i] = Jet(p[i], i);
  ProjectionState<L, Jet> state;
  const SplatShape<Jet> jet = Project(camera, jets + kMean, jets + kLogScale, jets + kQuaternion, state);
  for (int i = 0; i < kParameters; ++i) {
    double w[kSplatShape];
    TangentOf(
        jet, [i](const Jet& x) { return x.v[i]; }, w);
    for (int row = 0; row < kSplatShape; ++row) K[row][i] = w[row];
  }
}

// Relative to the row's largest entry within a group of parameters. For quaternions this includes the scales, because
// their derivative is a difference of terms of that size, which cancel for round splats.
inline void ExpectRowsNear(const double K[kSplatShape][kParameters], const double expected[kSplatShape][kParameters]) {
  for (int row = 0; row < kSplatShape; ++row) {
    double scale[3] = {};
    const auto group = [](int i) { return i < kLogScale ? 0 : i < kQuaternion ? 1 : 2; };
    for (int i = 0; i < kParameters; ++i) {
      scale[group(i)] = std::max(scale[group(i)], std::abs(expected[row][i]));
    }
    for (int i = 0; i < kParameters; ++i) {
      EXPECT_NEAR(K[row][i], expected[row][i], 1e-9 * scale[group(i)]) << "row " << row << ", parameter " << i;
    }
  }
}

template <class L>
void AdjointRows(const CameraConstants<double, L>& camera, const double* p, double K[kSplatShape][kParameters]) {
  ProjectionState<L, double> state;
  const SplatShape<double> shape = Project(camera, p + kMean, p + kLogScale, p + kQuaternion, state);
  for (int row = 0; row < kSplatShape; ++row) {
    double unit[kSplatShape] = {};
    unit[row] = 1;
    ProjectAdjoint(camera, p + kQuaternion, state, shape, unit, K[row] + kMean, K[row] + kLogScale,
                   K[row] + kQuaternion);
  }
}

}  // namespace vesta::splat
