// SPDX-License-Identifier: Apache-2.0
// A command with its arguments, flags and options, as it was given.
#pragma once

#include <string>
#include <vector>

#include "apps/cli/flags.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::app {

// An option of training that was given, by its own flag or by --set.
struct GivenOption {
  const schema::Field<gs::TrainOptions>* field;
  std::string value;  // one of the field's
};

struct CommandLine {
  const CommandInfo* command = nullptr;  // null: help
  std::vector<std::string> arguments;    // of the command; of help its topic, if any, and --all
  Flags flags = {};
  std::vector<GivenOption> options = {};  // in the order given: the last of one field counts
};

// Whether the command takes the option: config and train take all, refine those that a given model leaves open.
bool TakesOption(const CommandInfo& command, const schema::FieldInfo& option);

}  // namespace vesta::app
