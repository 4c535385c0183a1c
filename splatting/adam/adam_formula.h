// SPDX-License-Identifier: Apache-2.0
// The update of Adam (Kingma and Ba 2015, algorithm 1) for one parameter, or a vector of them: host and device call the
// same template.
//
// A parameter whose gradient is zero, as of every Gaussian that no view of the step sees, stays as it is and nothing of
// it is written, neither value nor moments: they are means over the steps that pull at it (the sparse Adam of Mallick
// et al., "Taming 3DGS", 2024). A view sees a part of the Gaussians, and a step is bound by memory.
#pragma once

#include <cmath>

#include "kernels/math/scalar.h"

namespace vesta::gs {
inline namespace VESTA_ISA {

// beta1 is usually 0.9: over the steps that pull at a Gaussian alone, a shorter mean follows better
// (docs/results/2026-11-22-sparse-adam.md).
inline constexpr float kAdamBeta1 = 0.7f, kAdamBeta2 = 0.999f;
// No second moment that is used is less: its root takes the part of Adam's epsilon. And none becomes a denormal number,
// which would cost a hundred times the work.
inline constexpr float kAdamSecondFloor = 1e-27f, kAdamFirstFloor = 1e-30f;

template <class V>
VESTA_HD inline V NextFirstMoment(const V& first, const V& gradient) {
  using std::abs;
  const V m = V(kAdamBeta1) * first + V(1 - kAdamBeta1) * gradient;
  return Select(abs(m) < V(kAdamFirstFloor), V(0), m);
}

template <class V>
VESTA_HD inline V NextSecondMoment(float beta2, const V& second, const V& gradient) {
  return Max(V(beta2) * second + V(1 - beta2) * gradient * gradient, V(kAdamSecondFloor));
}

// Brings the moments up to date with the gradient g and returns the step to take off the parameter; where g is zero the
// step is zero and the moments stay. rate: divided by the first moment's bias correction; root_correction2:
// 1 / sqrt(1 - beta2^steps); beta2: AdamRule's.
template <class V>
VESTA_HD inline V AdamStep(const V& g, const V& rate, float beta2, const V& root_correction2, V& first, V& second) {
  using std::sqrt;
  const auto moves = g != V(0);
  first = Select(moves, NextFirstMoment(first, g), first);
  second = Select(moves, NextSecondMoment(beta2, second, g), second);
  return Select(moves, rate * first / (sqrt(second) * root_correction2), V(0));
}

}  // namespace VESTA_ISA
}  // namespace vesta::gs
