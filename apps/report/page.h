// SPDX-License-Identifier: Apache-2.0
// The page of a report, its table of settings, its style and its script. It loads nothing from a network.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "apps/report/report.h"

namespace vesta::app {

// HTML with all that it shows within itself. What comes from files is escaped; a policy in its head forbids requests.
std::string ReportPage(const Report& report);

// Colours of runs, classes run0, run1, ... of what is drawn.
inline constexpr std::size_t kRunColors = 6;

std::string_view PageStyle();   // CSS
std::string_view PageScript();  // JavaScript

// HTML: first what a run has otherwise than its preset, or than another run; all the others folded away.
std::string SettingsTable(const Report& report);

}  // namespace vesta::app
