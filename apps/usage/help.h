// What `vesta help` prints.
#pragma once

#include <string>
#include <vector>

namespace vesta::app {

// The commands, or the flags of the one that `topic` names; with --all besides every option of training. Throws
// UsageError where there is no such command.
std::string HelpText(const std::vector<std::string>& topic);

}  // namespace vesta::app
