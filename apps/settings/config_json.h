// SPDX-License-Identifier: Apache-2.0
// Options of training as JSON: {"preset": NAME, "options": {"adam": {"iterations": 4000, ...}, "density": {...}, ...}}.
// metrics.json has them among other things, `vesta config` prints them, --config reads either.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "splatting/train/settings/train_options.h"

namespace vesta::app {

// Complete: every field of every room.
nlohmann::ordered_json OptionsJson(const gs::TrainOptions& options);

class ConfigFile {
 public:
  // Throws Error, as all of this does: one line that names the file and what of it.
  explicit ConfigFile(const std::string& path);
  // Of a text that stands in the file.
  ConfigFile(const std::string& path, const std::string& text);

  // Of a key beside the options; throws where there is none.
  std::string Text(const char* key) const;
  // The names and texts of an object; none where there is no such object.
  std::vector<std::pair<std::string, std::string>> Texts(const char* key) const;
  // Empty where it names none.
  std::string preset() const;
  // Sets the options that the file has; there may be any of them.
  void Apply(gs::TrainOptions& options) const;

 private:
  std::string path_;
  nlohmann::ordered_json json_;
};

}  // namespace vesta::app
