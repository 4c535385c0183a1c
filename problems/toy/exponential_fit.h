// SPDX-License-Identifier: Apache-2.0
// Fitting exp(m t + c) to samples of a noisy exponential, on request with outliers.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "kernels/core/hd.h"

namespace vesta {

// Residual of one observation, in units of y.
struct ExponentialFit {
  static constexpr int kResiduals = 1;
  static constexpr int kParameters = 2;  // m, c
  double t, y;

  template <class T>
  VESTA_HD void operator()(const T* p, T* r) const {
    using std::exp;
    r[0] = exp(p[0] * T(t) + p[1]) - T(y);
  }
};

// Truth of the samples below.
inline constexpr double kExponentialFitTruth[2] = {0.3, 0.1};

// `count` samples at t within [0, 5) with noise of up to +-0.1; every outlier_period-th is 3 too high (0: none).
inline std::vector<ExponentialFit> ExponentialSamples(int count, int outlier_period = 0) {
  std::vector<ExponentialFit> samples;
  std::uint32_t state = 2463534242u;
  for (int i = 0; i < count; ++i) {
    // Xorshift (Marsaglia, 2003).
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    const double noise = 0.2 * (state / 4294967296.0 - 0.5);
    const double t = 5.0 * i / count;
    const bool outlier = outlier_period > 0 && i % outlier_period == outlier_period / 2;
    samples.push_back(
        {t, std::exp(kExponentialFitTruth[0] * t + kExponentialFitTruth[1]) + noise + (outlier ? 3.0 : 0.0)});
  }
  return samples;
}

}  // namespace vesta
