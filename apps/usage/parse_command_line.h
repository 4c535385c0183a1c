// SPDX-License-Identifier: Apache-2.0
// Parses the command line.
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

}  // namespace vesta::app
