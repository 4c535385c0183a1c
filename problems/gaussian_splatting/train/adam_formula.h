// The update of Adam for one parameter, or a vector of them: host and device call the same template.
#pragma once

#include <cmath>

#include "kernels/math/scalar.h"

namespace vesta::gs {
inline namespace VESTA_ISA {

inline constexpr float kAdamBeta1 = 0.9f, kAdamBeta2 = 0.999f;
// Added to the second moment at every step, it settles at 1e-27: its root takes the part of Adam's epsilon, and no
// moment ever becomes a denormal number, which would cost a hundred times the work.
inline constexpr float kAdamSecondFloor = 1e-30f, kAdamFirstFloor = 1e-30f;

// Brings the moments up to date with the gradient g and returns the step to take off the parameter. rate: divided by
// the first moment's bias correction; root_correction2: 1 / sqrt(1 - beta2^steps).
template <class V>
VESTA_HD inline V AdamStep(const V& g, const V& rate, const V& root_correction2, V& first, V& second) {
  using std::abs, std::sqrt;
  const V beta1(kAdamBeta1), beta2(kAdamBeta2), rest1(1 - kAdamBeta1), rest2(1 - kAdamBeta2);
  const V m = beta1 * first + rest1 * g;
  first = Select(abs(m) < V(kAdamFirstFloor), V(0), m);
  second = beta2 * second + (rest2 * g * g + V(kAdamSecondFloor));
  return rate * first / (sqrt(second) * root_correction2);
}

}  // namespace VESTA_ISA
}  // namespace vesta::gs
