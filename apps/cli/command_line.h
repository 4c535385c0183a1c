// From argv to a command, its arguments, flags and options.
#pragma once

#include <string>
#include <vector>

#include "apps/cli/flags.h"
#include "splatting/train/settings/options.h"

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

// Throws UsageError: there is no command of that name, but perhaps one that is called alike.
[[noreturn]] void RefuseCommand(const std::string& name);

// `vesta`-wide help: help, --help, -h, also after a command. Throws UsageError: no or unknown command, unknown flag or
// key, one of another command, missing or impossible value, too few or too many arguments, no --out where results are
// written.
CommandLine ParseCommandLine(const std::vector<std::string>& words);

}  // namespace vesta::app
