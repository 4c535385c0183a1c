// SPDX-License-Identifier: Apache-2.0
// Parses the command line, and lists flags and training options of each command.
#pragma once

#include <string>
#include <vector>

#include "apps/cli/flags.h"

namespace vesta::app {

// Throws UsageError for an unknown command. The message suggests the most similar name.
[[noreturn]] void RefuseCommand(const std::string& name);

// Parses the words after the program name. help, --help and -h select help, also after a command. Throws UsageError for
// a missing or unknown command; for a flag or key that is unknown or belongs to another command; for a missing or
// invalid value; for too few or too many arguments; and for a missing --out.
CommandLine ParseCommandLine(const std::vector<std::string>& words);

// A flag of a command, or an option for --set, for help, manual page and completions.
struct ListedFlag {
  std::string name;  // flag without dashes, or key for --set
  const schema::FieldInfo* field;
  FlagGroup group;
  std::string value;  // default for the default preset; empty: none
  bool only_in_all = false;
  bool may_be_bare = false;  // the flag may have no value

  // Whether the flag is on or off, without a value.
  bool is_switch() const { return field->kind == schema::Kind::kSwitch; }
  // The flag as the user writes it to change the default: --NAME, or --noNAME for a switch that is on by default.
  std::string Written() const { return (is_switch() && value == "true" ? "--no" : "--") + name; }
};

// All flags of the command, including training options with their own flag, in the order of FlagGroup.
std::vector<ListedFlag> FlagsOf(const CommandInfo& command);
// All training options for --set; empty if the command has no --set.
std::vector<ListedFlag> OptionsOf(const CommandInfo& command);

}  // namespace vesta::app
