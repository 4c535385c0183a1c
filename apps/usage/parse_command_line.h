// SPDX-License-Identifier: Apache-2.0
// The command line: parses it, and lists the flags and options that each command takes.
#pragma once

#include <string>
#include <vector>

#include "apps/cli/flags.h"

namespace vesta::app {

// Throws UsageError: there is no command of that name, but perhaps one that is called alike.
[[noreturn]] void RefuseCommand(const std::string& name);

// `vesta`-wide help: help, --help, -h, also after a command. Throws UsageError: no or unknown command, unknown flag or
// key, one of another command, missing or impossible value, too few or too many arguments, no --out where results are
// written.
CommandLine ParseCommandLine(const std::vector<std::string>& words);

// The flags and options that a command takes, in the order of its help: what help, the manual and completions are made
// from.
struct ListedFlag {
  std::string name;  // without dashes; of an option of --set its key
  const schema::FieldInfo* field;
  FlagGroup group;
  std::string value;  // what it is without being given, of the default preset; empty: nothing
  bool only_in_all = false;
  bool may_be_bare = false;  // it can be written without a value too

  // A switch, which takes no value.
  bool is_switch() const { return field->kind == schema::Kind::kSwitch; }
  // As it is written: --noNAME for a switch that is on.
  std::string Written() const { return (is_switch() && value == "true" ? "--no" : "--") + name; }
};

// Its own flags, and those of options that have one.
std::vector<ListedFlag> FlagsOf(const CommandInfo& command);
// All options, which --set takes by their keys; none where the command has no --set.
std::vector<ListedFlag> OptionsOf(const CommandInfo& command);

}  // namespace vesta::app
