// config: the options that train would take, as JSON.
#include "apps/commands.h"
#include "apps/config_json.h"
#include "apps/print.h"
#include "apps/train_settings.h"

namespace vesta::app {

int RunConfig(const CommandLine& line) {
  const TrainSettings settings = SettingsOf(line);
  const nlohmann::ordered_json json = {{"preset", settings.preset}, {"options", OptionsJson(settings.options)}};
  Print("{}\n", json.dump(1));
  return 0;
}

}  // namespace vesta::app
