// A number as a colour.
#pragma once

#include <array>

namespace vesta::app {

// From black by red to pale yellow, r, g, b in 0..1. of: 0..1.
std::array<float, 3> HeatColor(float of);

}  // namespace vesta::app
