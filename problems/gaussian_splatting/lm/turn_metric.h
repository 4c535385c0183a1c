// The part of the damping metric that a splat's shape gives to its turning: for both memory spaces.
#pragma once

#include <cmath>

#include "kernels/core/hd.h"
#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/layout.h"

namespace vesta::gs {

// Adds it to D (layout.h; `count` Gaussians at x) for the quaternion of Gaussian i: a step dq of the quaternion turns
// the splat by up to 2 |dq| / |q|, which moves its ends, one standard deviation out, by up to 2 sigma_max |dq| / |q|,
// so D_q += D_mean (2 sigma_max / |q|)^2: the ends are as dear as the mean. A small round splat may turn as it likes; a
// long needle, which by a small angle sweeps views far from those that it is fitted to, may not.
template <class S>
struct AddTurnMetric {
  S mean_metric;  // D of a mean, times the weight of this part
  Index count;
  const S* x;
  S* D;

  VESTA_HD void operator()(Index i) const {
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
