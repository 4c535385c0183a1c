// SPDX-License-Identifier: Apache-2.0
// The part of the damping metric that goes by lengths: how far means move, and the ends of splats that turn. For both
// memory spaces.
#pragma once

#include <cmath>

#include "kernels/core/hd.h"
#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/formulas/layout.h"

namespace vesta::gs {

// Completes D (layout.h; `count` Gaussians at x) for the mean and the quaternion of Gaussian i.
// D of the mean, given for a unit of length of 1, is divided by the square of the Gaussian's unit.
// A step dq of the quaternion turns the splat by up to 2 |dq| / |q|, which moves its ends, one standard deviation out,
// by up to 2 sigma_max |dq| / |q|, so D_q += D_mean (2 sigma_max / |q|)^2: the ends are as dear as the
// mean. A small round splat may turn as it likes; a long needle, which by a small angle sweeps views far from those
// that it is fitted to, may not.
template <class S>
struct LengthMetric {
  Index count;
  const float* units;  // [count], of length; null: all 1
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
    // Finite for any finite x, and for a quaternion of zero.
    constexpr S kLeastSquare = S(1e-12), kMost = S(1e30);
    S ends = 4 * mean_metric * std::exp(2 * log_scale) / (square > kLeastSquare ? square : kLeastSquare);
    if (!(ends < kMost)) ends = kMost;
    for (int k = splat::kQuaternion; k < splat::kOpacity; ++k) D[k * count + i] += ends;
  }
};

}  // namespace vesta::gs
