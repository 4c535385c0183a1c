// SPDX-License-Identifier: Apache-2.0
// The texts of `vesta help`: help, manual page, and shell completions, from the tables of commands, flags and options.
#pragma once

#include <string>
#include <vector>

namespace vesta::app {

// The list of commands if `topic` is empty, else the flags of the command topic[0]; if `topic` contains "--all", also
// rare flags and all training options. Throws UsageError if there is no such command.
std::string HelpText(const std::vector<std::string>& topic);

// The manual page (section 1, roff).
std::string ManPage();

// The completion script for bash, zsh or fish. Throws UsageError for another shell.
std::string CompletionScript(const std::string& shell);

}  // namespace vesta::app
