// SPDX-License-Identifier: Apache-2.0
#include <cstring>

#include "splatting/io/splats/ply.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/splat_promise.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {
namespace {

bool Same(const gs::SplatModel& a, const gs::SplatModel& b) {
  return a.sh_degree == b.sh_degree && a.count == b.count && a.has_background == b.has_background &&
         a.background == b.background && a.origin == b.origin && a.eps2d == b.eps2d && a.antialiased == b.antialiased &&
         a.data.size() == b.data.size() &&
         std::memcmp(a.data.data(), b.data.data(), a.data.size() * sizeof(float)) == 0;
}

}  // namespace

void FuzzSplatPly(std::string_view bytes) {
  static const ScratchFolder folder;
  const std::string path = folder.Write("splat.ply", bytes), copy = folder / "copy.ply";
  gs::SplatModel model;
  if (!Reads(path, [&] { model = gs::ReadSplatPly(path); })) return;
  PromiseSplat(model);
  gs::WriteSplatPly(copy, model);
  Promise(Same(model, gs::ReadSplatPly(copy)), "writing and reading changes the splat");
}

}  // namespace vesta::fuzz
