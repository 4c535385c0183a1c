// SPDX-License-Identifier: Apache-2.0
// config: prints the options of train as JSON.
#include "apps/cli/print.h"
#include "apps/commands/commands.h"
#include "apps/settings/train_settings.h"

namespace vesta::app {

int RunConfig(const CommandLine& line) {
  const TrainSettings settings = SettingsOf(line);
  const nlohmann::ordered_json json = {{"preset", settings.preset}, {"options", OptionsJson(settings.options)}};
  Print("{}\n", json.dump(1));
  return 0;
}

}  // namespace vesta::app
