// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/splat_file.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/splat_promise.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {

void FuzzAntimatterSplat(std::string_view bytes) {
  static const ScratchFolder folder;
  const std::string path = folder.Write("fuzzed.splat", bytes);
  gs::SplatModel model;
  if (!Reads(path, [&] { model = gs::ReadSplat(path); })) return;
  PromiseSplat(model);
  PromiseItSurvives(model, folder / "copy.splat",
                    [](const std::string& copy, const gs::SplatModel& splat) { gs::WriteSplat(copy, splat); });
}

}  // namespace vesta::fuzz
