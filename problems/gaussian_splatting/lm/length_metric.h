// SPDX-License-Identifier: Apache-2.0
// Changes the damping metric D of (H + lambda D) step = -gradient, so that LM damps lengths: how far means move, and
// how far rotations move the ends of splats. Runs on host and device.
#pragma once

#include <cmath>

#include "kernels/core/hd.h"
#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/formulas/layout.h"

namespace vesta::gs {

// Changes D of Gaussian i for its mean and quaternion. x and D: layout of layout.h, `count` Gaussians.
//
// * Mean: D is divided by the square of the Gaussian's unit of length (model/length_units.h).
// * Quaternion q: D_q += D_mean (2 sigma_max / |q|)^2, where D_mean is the new D of the mean and sigma_max the largest
//   standard deviation.
// Reason for the second rule: a step dq rotates the splat by up to 2 |dq| / |q|. Its ends, at sigma_max from the mean,
// move by up to 2 sigma_max |dq| / |q|. So LM damps the ends like the mean. Otherwise even a small rotation of a long
// needle could move the ends of the needle into other views.
template <class S>
struct LengthMetric {
  Index count;
  const float* units;  // unit of length of each Gaussian; null: all 1
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
