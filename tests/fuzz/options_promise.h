// SPDX-License-Identifier: Apache-2.0
// What holds of options that were read, from a file or from a command line.
#pragma once

#include "apps/settings/train_settings.h"
#include "splatting/train/settings/train_options.h"
#include "tests/fuzz/promise.h"

namespace vesta::fuzz {

// Each is one of its field's values, and as JSON they read back as they are. Together they may be refused. Throws
// Finding.
inline void PromiseOptions(const gs::TrainOptions& options) {
  gs::TrainOptions again;
  app::ConfigFile("options", nlohmann::ordered_json{{"options", app::OptionsJson(options)}}.dump()).Apply(again);
  for (const schema::Field<gs::TrainOptions>& field : gs::TrainFields()) {
    Promise(field.IsValid(options), field.name + " has a value that it may not have");
    Promise(field.Text(options) == field.Text(again), field.name + " reads back as another value");
  }
  try {
    gs::ValidateOptions(options);
  } catch (const Error& error) {
    PromiseOneLine(error.what());
  }
}

}  // namespace vesta::fuzz
