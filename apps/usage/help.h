// SPDX-License-Identifier: Apache-2.0
// What `vesta help` prints, the manual, and scripts by which shells complete the command line.
#pragma once

#include <string>
#include <vector>

namespace vesta::app {

// The commands, or the flags of the one that `topic` names; with --all besides every option of training. Throws
// UsageError where there is no such command.
std::string HelpText(const std::vector<std::string>& topic);

// Section 1, in the language of man (roff), made from the tables of commands, flags and options.
std::string ManPage();

// The script for bash, zsh or fish, made from the tables of commands, flags and options. Throws UsageError for any
// other shell.
std::string CompletionScript(const std::string& shell);

}  // namespace vesta::app
