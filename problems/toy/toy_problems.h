// SPDX-License-Identifier: Apache-2.0
// Small test problems: an exponential fit, Powell's singular function, and Rosenbrock's valley.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "kernels/core/hd.h"
#include "kernels/core/span.h"

namespace vesta {

// The residual of one sample (t, y) for the curve y = exp(m t + c).
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

// True parameters of the samples below.
inline constexpr double kExponentialFitTruth[2] = {0.3, 0.1};

// `count` samples at t in [0, 5) with noise of up to +-0.1; every outlier_period-th sample is 3 too high (0: none).
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

// Powell's singular function (1962). The minimum is 0 at the origin, where the Jacobian has rank 2 instead of 4.
struct Powell {
  static constexpr int kResiduals = 4;
  static constexpr int kParameters = 4;
  static constexpr double kStart[4] = {3, -1, 0, 1};

  template <class T>
  VESTA_HD void operator()(const T* x, T* r) const {
    const T between = x[1] - T(2) * x[2], ends = x[0] - x[3];
    r[0] = x[0] + T(10) * x[1];
    r[1] = T(2.2360679774997896964) * (x[2] - x[3]);
    r[2] = between * between;
    r[3] = T(3.1622776601683793320) * ends * ends;
  }
};

// Rosenbrock's curved valley (1960) as residuals 10 (x2 - x1^2) and 1 - x1. The minimum is 0 at (1, 1).
struct Rosenbrock {
  static constexpr int kResiduals = 2;
  static constexpr int kParameters = 2;
  static constexpr double kStart[2] = {-1.2, 1};

  template <class T>
  VESTA_HD void operator()(const T* x, T* r) const {
    r[0] = T(10) * (x[1] - x[0] * x[0]);
    r[1] = T(1) - x[0];
  }
};

// Parameter indices of n - 1 Rosenbrock functors over n variables: functor i depends on x_i and x_{i+1}. The minimum is
// 0, where all variables are 1.
inline std::vector<Index> RosenbrockChain(Index n) {
  std::vector<Index> index;
  for (Index i = 0; i + 1 < n; ++i) {
    index.push_back(i);
    index.push_back(i + 1);
  }
  return index;
}

}  // namespace vesta
