// SPDX-License-Identifier: Apache-2.0
// How the page of a report looks and moves: parts of the page itself, which asks nothing of a network.
#pragma once

#include <cstddef>
#include <string_view>

namespace vesta::app {

// Colours of runs, classes run0, run1, ... of what is drawn.
inline constexpr std::size_t kRunColors = 6;

std::string_view PageStyle();   // CSS
std::string_view PageScript();  // JavaScript

}  // namespace vesta::app
