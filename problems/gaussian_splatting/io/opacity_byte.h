// Opacities of compact files: one byte of 0..1 for a logit.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vesta::gs {

// The nearest of 1..254. 0 and 255 are opacities too, but their logits are infinite, which other readers give on.
inline std::uint8_t OpacityByte(float logit) {
  const double opacity = 1 / (1 + std::exp(-static_cast<double>(logit)));
  return static_cast<std::uint8_t>(std::clamp(std::round(255 * opacity), 1.0, 254.0));
}

// Finite: 0 and 255 are taken for the middle of the opacities that are rounded to them.
inline float OpacityLogit(std::uint8_t byte) {
  const double opacity = std::clamp(static_cast<double>(byte), 0.25, 254.75) / 255;
  return static_cast<float>(std::log(opacity / (1 - opacity)));
}

}  // namespace vesta::gs
