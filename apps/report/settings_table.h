// SPDX-License-Identifier: Apache-2.0
// The settings of trainings, side by side.
#pragma once

#include <string>

#include "apps/report/report.h"

namespace vesta::app {

// HTML: first what a run has otherwise than its preset, or than another run; all the others folded away.
std::string SettingsTable(const Report& report);

}  // namespace vesta::app
