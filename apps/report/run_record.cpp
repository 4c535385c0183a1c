// SPDX-License-Identifier: Apache-2.0
#include "apps/report/run_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/schema.h"

namespace vesta::app {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

RunRecord::RunRecord(std::string name, const std::string& metrics, std::int64_t splat_bytes)
    : name_(std::move(name)), json_(Json::parse(metrics, nullptr, false)), splat_bytes_(splat_bytes) {
  if (!json_.is_object()) Fail(kBadFile, "{}: its metrics.json is not that of a training", name_);
}

const Json* RunRecord::At(const std::string& path) const {
  const Json* at = &json_;
  for (const std::string& key : schema::SplitAt(path, '.')) {
    if (!at->is_object()) return nullptr;
    const auto found = at->find(key);
    if (found == at->end()) return nullptr;
    at = &*found;
  }
  return at;
}

double RunRecord::Number(const std::string& path) const {
  const Json* at = At(path);
  return at && at->is_number() ? at->get<double>() : NAN;
}

std::string RunRecord::Text(const std::string& path) const {
  const Json* at = At(path);
  return at && at->is_string() ? at->get<std::string>() : "";
}

std::vector<std::string> RunRecord::notes() const {
  std::vector<std::string> notes;
  const Json* at = At("notes");
  if (!at || !at->is_array()) return notes;
  for (const Json& note : *at) {
    if (note.is_string()) notes.push_back(note.get<std::string>());
  }
  return notes;
}

std::vector<PhaseRow> RunRecord::phases() const {
  std::vector<PhaseRow> rows;
  const Json* at = At("profile");
  if (!at || !at->is_array()) return rows;
  for (const Json& row : *at) {
    const auto number = [&](const char* key) {
      return row.contains(key) && row[key].is_number() ? row[key].get<double>() : 0;
    };
    if (!row.is_object() || !row.contains("phase") || !row["phase"].is_string()) continue;
    rows.push_back({row["phase"],
                    static_cast<int>(std::clamp(number("depth"), 0.0, 9.0)),
                    static_cast<std::int64_t>(std::clamp(number("calls"), 0.0, 1e15)),
                    {number("wall_seconds"), number("cpu_seconds")}});
  }
  return rows;
}

std::vector<double> RunRecord::History(const char* figure) const {
  std::vector<double> figures;
  const Json* at = At("history");
  if (!at || !at->is_array()) return figures;
  for (const Json& row : *at) {
    const bool is_there = row.is_object() && row.contains(figure) && row[figure].is_number();
    figures.push_back(is_there ? row[figure].get<double>() : NAN);
  }
  return figures;
}

std::vector<std::pair<std::string, std::string>> RunRecord::Options() const {
  const Json* at = At("options");
  return at ? Flattened(*at) : std::vector<std::pair<std::string, std::string>>();
}

RunRecord ReadRun(const std::string& folder) {
  const std::string metrics = (fs::path(folder) / "metrics.json").string();
  std::error_code missing;
  const std::uintmax_t bytes = fs::file_size(fs::path(folder) / "point_cloud.ply", missing);
  return {folder, ReadFile(metrics), missing ? 0 : static_cast<std::int64_t>(bytes)};
}

std::vector<std::pair<std::string, std::string>> Flattened(const Json& object) {
  std::vector<std::pair<std::string, std::string>> flat;
  if (!object.is_object()) return flat;
  for (const auto& [part, values] : object.items()) {
    if (!values.is_object()) continue;
    for (const auto& [key, value] : values.items()) {
      flat.emplace_back(fmt::format("{}.{}", part, key), value.is_string() ? value.get<std::string>() : value.dump());
    }
  }
  return flat;
}

}  // namespace vesta::app
