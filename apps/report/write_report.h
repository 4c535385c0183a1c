// From runs to the file of their report.
#pragma once

#include <string>
#include <vector>

#include "apps/report/report.h"

namespace vesta::app {

// What RunSource::scene is of a scene's folder, whose images are divided in size by the factor.
std::string SceneToReport(const std::string& folder, int downscale);

// Gathers, and writes the page whole or not at all. Throws Error where it cannot be written. Returns a line for each
// run whose test views could not be shown.
std::vector<std::string> WriteReport(const std::string& file, std::vector<RunSource> runs, const SplatLoader& load);

}  // namespace vesta::app
