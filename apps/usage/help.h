// SPDX-License-Identifier: Apache-2.0
// What `vesta help` prints, and the manual.
#pragma once

#include <string>
#include <vector>

namespace vesta::app {

// What `vesta help` prints.

// The commands, or the flags of the one that `topic` names; with --all besides every option of training. Throws
// UsageError where there is no such command.
std::string HelpText(const std::vector<std::string>& topic);

// The manual, for `man`.

// Section 1, in the language of man (roff), made from the tables of commands, flags and options.
std::string ManPage();

}  // namespace vesta::app
