// Colours as an image file of 8 bits holds them.
#pragma once

#include <algorithm>
#include <cmath>

#include "kernels/core/hd.h"
#include "kernels/math/isa.h"

namespace vesta {
inline namespace VESTA_ISA {

// x as an 8-bit value shows it: round(255 clamp(x, 0, 1)) / 255. Not a number stays not a number.
VESTA_HD inline float QuantizeTo8Bit(float x) {
  using std::clamp, std::floor;
  return floor(255.0f * clamp(x, 0.0f, 1.0f) + 0.5f) / 255.0f;
}

}  // namespace VESTA_ISA
}  // namespace vesta
