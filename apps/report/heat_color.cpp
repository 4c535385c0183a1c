#include "apps/report/heat_color.h"

#include <algorithm>
#include <cstddef>

namespace vesta::app {
namespace {

// Of matplotlib's inferno, which the page's scale shows too.
constexpr std::array<std::array<float, 3>, 6> kColors = {{{0.000f, 0.000f, 0.016f},
                                                          {0.259f, 0.039f, 0.408f},
                                                          {0.576f, 0.149f, 0.404f},
                                                          {0.867f, 0.318f, 0.227f},
                                                          {0.988f, 0.647f, 0.039f},
                                                          {0.988f, 1.000f, 0.643f}}};

}  // namespace

std::array<float, 3> HeatColor(float of) {
  const float at = of * static_cast<float>(kColors.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(at), kColors.size() - 2);
  const float part = at - static_cast<float>(below);
  std::array<float, 3> color;
  for (std::size_t c = 0; c < 3; ++c) color[c] = (1 - part) * kColors[below][c] + part * kColors[below + 1][c];
  return color;
}

}  // namespace vesta::app
