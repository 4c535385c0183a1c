// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/antimatter_splat.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/splat_promise.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {

void FuzzAntimatterSplat(std::string_view bytes) {
  static const ScratchFolder folder;
  const std::string path = folder / "fuzzed.splat";
  gs::SplatModel model;
  if (!Reads(path, [&] { model = gs::ReadAntimatterSplat(path, bytes, nullptr); })) return;
  PromiseSplat(model);
  // ReadSplat could find the magic number of another format in the first mean.
  const std::string copy = folder / "copy.splat";
  gs::WriteAntimatterSplat(copy, model, nullptr);
  const gs::SplatModel again = gs::ReadAntimatterSplat(copy, ReadFile(copy), nullptr);
  PromiseSplat(again);
  Promise(again.count == model.count, "writing and reading changes the splat");
}

}  // namespace vesta::fuzz
