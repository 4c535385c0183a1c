// SPDX-License-Identifier: Apache-2.0
// The page of a report.
#pragma once

#include <string>

#include "apps/report/report.h"

namespace vesta::app {

// HTML with all that it shows within itself. What comes from files is escaped; a policy in its head forbids requests.
std::string ReportPage(const Report& report);

}  // namespace vesta::app
