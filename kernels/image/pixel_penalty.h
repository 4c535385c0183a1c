// SPDX-License-Identifier: Apache-2.0
// The penalty of one pixel and channel (loss_options.h), its derivative and the curvature of its quadratic.
//
// All penalties are special cases of one form of Huber's function. One vectorised function without branches computes
// it. With s = clamp(gain e, -limit, limit):
//   value = s (e - half_step s) + offset,   derivative = s,
//   curvature = numerator / (slope max(|e|, min_error) + intercept).
#pragma once

#include "kernels/image/loss_options.h"
#include "kernels/math/scalar.h"

namespace vesta {

template <class S>
struct PenaltyCoefficients {
  S gain, limit, half_step, offset;
  S numerator, min_error, slope, intercept;
};

// If l1_floor is 0, the value uses the smallest normal number as the floor, and the curvature uses 1e-30. S is float or
// double.
template <class S>
PenaltyCoefficients<S> PenaltyCoefficientsOf(const PhotometricWeights& weights);

inline namespace VESTA_ISA {

// The penalty of a pixel with error e: |e|, value and derivative. T: scalar or SIMD.
template <class T>
struct PixelPenalty {
  T absolute, derivative, value;

  template <class S>
  VESTA_HD PixelPenalty(const T& e, const PenaltyCoefficients<S>& c) {
    absolute = Max(e, -e);
    derivative = Clamp(T(c.gain) * e, T(-c.limit), T(c.limit));
    value = Fma(derivative, Fnma(T(c.half_step), derivative, e), T(c.offset));
  }
  template <class S>
  VESTA_HD T Curvature(const PenaltyCoefficients<S>& c) const {
    return T(c.numerator) * Reciprocal(Fma(T(c.slope), Max(absolute, T(c.min_error)), T(c.intercept)));
  }
};

}  // namespace VESTA_ISA
}  // namespace vesta
