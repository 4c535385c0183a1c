#include "apps/report/write_report.h"

#include <fmt/format.h>

#include <filesystem>

#include "apps/report/page.h"
#include "kernels/core/atomic_file.h"

namespace vesta::app {

std::string SceneToReport(const std::string& folder, int downscale) {
  const std::string path = std::filesystem::absolute(folder).lexically_normal().string();
  return downscale == 1 ? path : fmt::format("{}, by {} smaller", path, downscale);
}

std::vector<std::string> WriteReport(const std::string& file, std::vector<RunSource> runs, const SplatLoader& load) {
  const Report report = GatherReport(std::move(runs), load);
  WriteFileAtomically(file, ReportPage(report));
  std::vector<std::string> missing;
  for (const ReportedRun& run : report.runs) {
    if (run.missing.empty()) continue;
    missing.push_back(
        fmt::format("{}: the report does not show its test views: {}", run.source.record.name(), run.missing));
  }
  return missing;
}

}  // namespace vesta::app
