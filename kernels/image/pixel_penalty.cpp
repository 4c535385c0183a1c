// SPDX-License-Identifier: Apache-2.0
#include "kernels/image/pixel_penalty.h"

#include <algorithm>
#include <limits>

namespace vesta {

template <class S>
PenaltyCoefficients<S> PenaltyCoefficientsOf(const PhotometricWeights& weights) {
  switch (weights.pixel) {
    case PixelLinearization::kHuber: {
      const auto t = static_cast<S>(weights.huber_threshold);
      return {.gain = 1,
              .limit = t,
              .half_step = S(0.5),
              .offset = 0,
              .numerator = t,
              .min_error = t,
              .slope = 2,
              .intercept = -t};
    }
    case PixelLinearization::kL2:
      return {.gain = 1,
              .limit = std::numeric_limits<S>::max(),
              .half_step = S(0.5),
              .offset = 0,
              .numerator = 1,
              .min_error = 0,
              .slope = 0,
              .intercept = 1};
    case PixelLinearization::kIrls:
    case PixelLinearization::kSqrt:
      break;
  }
  const S floor = std::max(static_cast<S>(weights.l1_floor), std::numeric_limits<S>::min());
  return {.gain = 1 / floor,
          .limit = 1,
          .half_step = floor / 2,
          .offset = floor / 2,
          .numerator = weights.pixel == PixelLinearization::kSqrt ? S(0.5) : S(1),
          .min_error = std::max(floor, S(1e-30)),
          .slope = 1,
          .intercept = 0};
}

template PenaltyCoefficients<float> PenaltyCoefficientsOf<float>(const PhotometricWeights&);
template PenaltyCoefficients<double> PenaltyCoefficientsOf<double>(const PhotometricWeights&);

}  // namespace vesta
