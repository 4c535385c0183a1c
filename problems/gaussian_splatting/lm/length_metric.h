// SPDX-License-Identifier: Apache-2.0
// The length-based part of the damping metric: how far means move, and how far the ends of turning splats move. For
// both memory spaces.
#pragma once

#include <cmath>

#include "kernels/core/hd.h"
#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/formulas/layout.h"

namespace vesta::gs {

// Completes D for the mean and the quaternion of Gaussian i (layout.h; `count` Gaussians at x).
// On input, D of the mean assumes a unit of length of 1; it is divided by the square of the Gaussian's unit.
// A quaternion step dq turns the splat by up to 2 |dq| / |q|. This moves its ends, one standard deviation from the
// mean, by up to 2 sigma_max |dq| / |q|. Therefore D_q += D_mean (2 sigma_max / |q|)^2, so that moving the ends is
// penalised like moving the mean. A small round splat can turn freely. A long needle cannot: a small rotation would
// sweep it across views far from those it was fitted to.
template <class S>
struct LengthMetric {
  Index count;
  const float* units;  // [count], lengths; null: all 1
  const S* x;
  S* D;

  VESTA_HD void operator()(Index i) const {
    const S unit = units ? static_cast<S>(units[i]) : S(1);
    const S mean_metric = D[splat::kMean * count + i] / (unit * unit);
    for (int k = splat::kMean; k < splat::kLogScale; ++k) D[k * count + i] = mean_metric;

    S log_scale = x[splat::kLogScale * count + i], square = 0;
    for (int k = splat::kLogScale + 1; k < splat::kQuaternion; ++k) {
      log_scale = x[k * count + i] > log_scale ? x[k * count + i] : log_scale;
    }
    for (int k = splat::kQuaternion; k < splat::kOpacity; ++k) square += x[k * count + i] * x[k * count + i];
    // Stays finite for any finite x, including a zero quaternion.
    constexpr S kLeastSquare = S(1e-12), kMost = S(1e30);
    S ends = 4 * mean_metric * std::exp(2 * log_scale) / (square > kLeastSquare ? square : kLeastSquare);
    if (!(ends < kMost)) ends = kMost;
    for (int k = splat::kQuaternion; k < splat::kOpacity; ++k) D[k * count + i] += ends;
  }
};

}  // namespace vesta::gs
