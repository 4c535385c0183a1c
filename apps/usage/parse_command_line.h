// SPDX-License-Identifier: Apache-2.0
// Parses the command line, and lists the flags and options of each command.
#pragma once

#include <string>
#include <vector>

#include "apps/cli/flags.h"

namespace vesta::app {

// Throws UsageError for an unknown command, with the most similar name.
[[noreturn]] void RefuseCommand(const std::string& name);

// help, --help and -h give help, also after a command. Throws UsageError for a missing or unknown command; for an
// unknown flag or key, or one of another command; for a missing or invalid value; for too few or too many arguments;
// and for a missing --out.
CommandLine ParseCommandLine(const std::vector<std::string>& words);

// A flag or option of a command. Help, manual and completions are generated from lists of these.
struct ListedFlag {
  std::string name;  // without dashes; for --set the key of the option
  const schema::FieldInfo* field;
  FlagGroup group;
  std::string value;  // default, with the default preset; empty: none
  bool only_in_all = false;
  bool may_be_bare = false;  // the value is optional

  // Whether the flag has no value.
  bool is_switch() const { return field->kind == schema::Kind::kSwitch; }
  // As on the command line: --NAME, or --noNAME for a switch that is on by default.
  std::string Written() const { return (is_switch() && value == "true" ? "--no" : "--") + name; }
};

// All flags of the command, with the flags of options, in the order of FlagGroup.
std::vector<ListedFlag> FlagsOf(const CommandInfo& command);
// All options that the command accepts by --set; empty if it has no --set.
std::vector<ListedFlag> OptionsOf(const CommandInfo& command);

}  // namespace vesta::app
