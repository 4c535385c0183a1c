// SPDX-License-Identifier: Apache-2.0
// Makes the help, the manual page and the shell completions from the tables of commands, flags and options.
#pragma once

#include <string>
#include <vector>

namespace vesta::app {

// Returns the list of commands if `topic` is empty, else the flags of the command topic[0]. If `topic` contains
// "--all", the text also has rare flags and all training options. Throws UsageError if there is no such command.
std::string HelpText(const std::vector<std::string>& topic);

// The manual page (section 1, roff).
std::string ManPage();

// The completion script for bash, zsh or fish. Throws UsageError for another shell.
std::string CompletionScript(const std::string& shell);

}  // namespace vesta::app
