// SPDX-License-Identifier: Apache-2.0
// The HTML page of a report, with all images, styles and scripts.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "apps/report/report.h"

namespace vesta::app {

// Text from files is escaped, and a Content-Security-Policy forbids network requests.
std::string ReportPage(const Report& report);

// Number of colours for runs: the CSS classes run0, run1, ...
inline constexpr std::size_t kRunColors = 6;

std::string_view PageStyle();   // CSS
std::string_view PageScript();  // JavaScript

// HTML table of the settings of all runs. Settings that differ from the preset or between runs come first; the others
// are collapsed.
std::string SettingsTable(const Report& report);

}  // namespace vesta::app
