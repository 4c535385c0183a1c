// SPDX-License-Identifier: Apache-2.0
// What the files of a finished training say of it. They may be of another version, or written by hand: what is missing
// or of another kind is not known, and no error.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "kernels/core/profile.h"

namespace vesta::app {

class RunRecord {
 public:
  // name: what the run is called; metrics: the text of its metrics.json. Throws Error, one line that names the run,
  // where that is no JSON object.
  RunRecord(std::string name, const std::string& metrics, std::int64_t splat_bytes);

  const std::string& name() const { return name_; }
  std::int64_t splat_bytes() const { return splat_bytes_; }  // of point_cloud.ply; 0: there is none
  // At a path of keys, "seconds.total". NaN, and "", where it is not there.
  double Number(const std::string& path) const;
  std::string Text(const std::string& path) const;
  std::vector<std::string> notes() const;
  std::vector<PhaseRow> phases() const;  // of --profile
  // One of the figures of each row of the history of a stage.
  std::vector<double> History(const char* figure) const;
  // Every option, "adam.iterations", as text.
  std::vector<std::pair<std::string, std::string>> Options() const;
  const nlohmann::ordered_json& json() const { return json_; }

 private:
  const nlohmann::ordered_json* At(const std::string& path) const;  // null: not there

  std::string name_;
  nlohmann::ordered_json json_;
  std::int64_t splat_bytes_;
};

// DIR/metrics.json and DIR/point_cloud.ply. Throws Error where the first cannot be read.
RunRecord ReadRun(const std::string& folder);

// Every value beneath an object of objects, "part.key", as text.
std::vector<std::pair<std::string, std::string>> Flattened(const nlohmann::ordered_json& object);

}  // namespace vesta::app
