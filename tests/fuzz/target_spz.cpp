// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "splatting/io/bytes/bytes.h"
#include "splatting/io/splats/spz.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/splat_promise.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {

// Gzip's checksum would reject every mutation, so the input is compressed here.
void FuzzSpz(std::string_view bytes) {
  static const ScratchFolder folder;
  const bool is_zipped = bytes.starts_with("\x1f\x8b");
  // A first line becomes the gzip comment.
  const std::size_t line = std::min(bytes.find('\n'), bytes.size());
  const bool has_comment = bytes.starts_with("vesta") && line < bytes.size();
  const std::string comment(bytes.substr(0, has_comment ? line : 0));
  const std::string_view rest = bytes.substr(has_comment ? line + 1 : 0);
  const std::string path = folder.Write("splat.spz", is_zipped ? std::string(bytes) : gs::Gzip(rest, comment));
  gs::SplatModel model;
  if (!Reads(path, [&] { model = gs::ReadSpz(path); })) return;
  PromiseSplat(model);
  PromiseItSurvives(model, folder / "copy.spz", [](const std::string& copy, const gs::SplatModel& splat) {
    gs::WriteSpz(copy, splat, gs::kUniversalSpz);
  });
}

}  // namespace vesta::fuzz
