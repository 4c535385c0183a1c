// SPDX-License-Identifier: Apache-2.0
#include "apps/settings/train_settings.h"
#include "tests/fuzz/options_promise.h"
#include "tests/fuzz/promise.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {

void FuzzConfig(std::string_view bytes) {
  static const ScratchFolder folder;
  const std::string path = folder.Write("config.json", bytes);
  gs::TrainOptions options;
  const bool reads = Reads(path, [&] {
    const app::ConfigFile file(path);
    const std::string preset = file.preset();
    if (!preset.empty()) options = gs::PresetOptions(preset);
    file.Apply(options);
  });
  if (reads) PromiseOptions(options);
}

}  // namespace vesta::fuzz
