// SPDX-License-Identifier: Apache-2.0
// The texts of `vesta help`: help, manual page, and completion scripts for shells.
#pragma once

#include <string>
#include <vector>

namespace vesta::app {

// The list of commands, or the flags of the command in `topic`; with --all also all training options. Throws UsageError
// if there is no such command.
std::string HelpText(const std::vector<std::string>& topic);

// The manual page (section 1, roff), generated from the tables of commands, flags and options.
std::string ManPage();

// The completion script for bash, zsh or fish, generated from the same tables. Throws UsageError for another shell.
std::string CompletionScript(const std::string& shell);

}  // namespace vesta::app
