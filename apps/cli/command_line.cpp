// SPDX-License-Identifier: Apache-2.0
#include "apps/cli/command_line.h"

namespace vesta::app {

bool TakesOption(const CommandInfo& command, const schema::FieldInfo& option) {
  if (command.command & (kTrain | kConfig)) return true;
  if (!(command.command & (kRefine | kPrune))) return false;
  // These are the model's, or of growth, of which there is none; who refines takes none out.
  if (option.name.starts_with("parsimony.") && command.command != kPrune) return false;
  return !option.name.starts_with("density.") && option.name != "train.sh_degree" &&
         option.name != "train.background" && option.name != "train.low_pass";
}

}  // namespace vesta::app
