// SPDX-License-Identifier: Apache-2.0
// Completion of the command line by shells.
#pragma once

#include <string>

namespace vesta::app {

// The script for bash, zsh or fish, made from the tables of commands, flags and options. Throws UsageError for any
// other shell.
std::string CompletionScript(const std::string& shell);

}  // namespace vesta::app
