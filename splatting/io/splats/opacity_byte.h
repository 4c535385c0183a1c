// Opacities of compact files: one byte of 0..1 for a logit.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vesta::gs {

// The nearest of 1..254 where there is anything to see, which is from an opacity of 1/255 on (docs/conventions.md),
// else 0: rounded up it would be seen. 255 is an opacity too, but its logit is infinite, and no renderer tells it from
// 254.
inline std::uint8_t OpacityByte(float logit) {
  const double parts = 255 / (1 + std::exp(-static_cast<double>(logit)));
  return parts < 1 ? std::uint8_t{0} : static_cast<std::uint8_t>(std::min(std::round(parts), 254.0));
}

// Finite: 0 and 255 are taken for the middle of the opacities that are rounded to them.
inline float OpacityLogit(std::uint8_t byte) {
  const double opacity = std::clamp(static_cast<double>(byte), 0.25, 254.75) / 255;
  return static_cast<float>(std::log(opacity / (1 - opacity)));
}

}  // namespace vesta::gs
