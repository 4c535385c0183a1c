// SPDX-License-Identifier: Apache-2.0
#include "kernels/image/gaussian_window.h"

#include <cmath>

namespace vesta {

std::array<double, kWindowTaps> GaussianTaps() {
  constexpr double kSigma = 1.5;
  std::array<double, kWindowTaps> taps{};
  double sum = 0.0;
  for (int k = 0; k < kWindowTaps; ++k) {
    const double offset = (k - kWindowRadius) / kSigma;
    sum += taps[static_cast<std::size_t>(k)] = std::exp(-0.5 * offset * offset);
  }
  for (double& tap : taps) tap /= sum;
  return taps;
}

double WindowVariance() {
  double variance = 0.0;
  int offset = -kWindowRadius;
  for (const double tap : GaussianTaps()) variance += tap * offset * offset, ++offset;
  return variance;
}

}  // namespace vesta
