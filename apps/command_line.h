// From argv to a command, its arguments and set flags.
#pragma once

#include <string>
#include <vector>

#include "apps/flags.h"

namespace vesta::app {

struct CommandLine {
  const CommandInfo* command = nullptr;  // null: help
  std::vector<std::string> arguments;    // of the command; the topic, if any, of help
};

// Checks every word against the table of flags first, so that whatever is wrong is one line of ours (gflags would
// print its own and exit), then lets gflags set the flags. `vesta`-wide help: help, --help, -h, also after a command.
// Throws UsageError: no or unknown command, unknown flag, flag of another command, missing or impossible value, too
// few or too many arguments, no --out where results are written.
CommandLine ParseCommandLine(int argc, char** argv);

}  // namespace vesta::app
