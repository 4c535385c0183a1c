// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/compressed_ply.h"
#include "splatting/io/splats/splat_file.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/splat_promise.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {

// Uses the reader for all formats, which detects compression.
void FuzzCompressedPly(std::string_view bytes) {
  static const ScratchFolder folder;
  const std::string path = folder.Write("splat.compressed.ply", bytes);
  gs::SplatModel model;
  if (!Reads(path, [&] { model = gs::ReadSplat(path); })) return;
  PromiseSplat(model);
  PromiseItSurvives(model, folder / "copy.compressed.ply", gs::WriteCompressedPly);
}

}  // namespace vesta::fuzz
