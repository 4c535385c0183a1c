// SPDX-License-Identifier: Apache-2.0
// The invariants of options read from a file or a command line.
#pragma once

#include "apps/settings/train_settings.h"
#include "splatting/train/settings/train_options.h"
#include "tests/fuzz/promise.h"

namespace vesta::fuzz {

// Every option has a valid value that survives JSON. The combination may be invalid. Throws Finding.
inline void PromiseOptions(const gs::TrainOptions& options) {
  gs::TrainOptions again;
  app::ConfigFile("options", nlohmann::ordered_json{{"options", app::OptionsJson(options)}}.dump()).Apply(again);
  for (const schema::Field<gs::TrainOptions>& field : gs::TrainFields()) {
    Promise(field.IsValid(options), field.name + " has an invalid value");
    Promise(field.Text(options) == field.Text(again), field.name + " is read back with another value");
  }
  try {
    gs::ValidateOptions(options);
  } catch (const Error& error) {
    PromiseOneLine(error.what());
  }
}

}  // namespace vesta::fuzz
