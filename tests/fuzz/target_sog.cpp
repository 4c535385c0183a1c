// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "splatting/io/bytes/zip.h"
#include "splatting/io/splats/sog.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/splat_promise.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {
namespace {

// The first line is meta.json. Each further file, named 0, 1 and so on, begins with "RIFF".
std::string Bundle(std::string_view bytes) {
  const std::size_t line = std::min(bytes.find('\n'), bytes.size());
  std::vector<gs::ZipEntry> entries = {{"meta.json", std::string(bytes.substr(0, line))}};
  bytes.remove_prefix(std::min(line + 1, bytes.size()));
  while (!bytes.empty()) {
    const std::size_t end = std::min(bytes.find("RIFF", 1), bytes.size());
    entries.push_back({std::to_string(entries.size() - 1), std::string(bytes.substr(0, end))});
    bytes.remove_prefix(end);
  }
  return gs::Zip(entries);
}

}  // namespace

// The checksums of a zip archive would reject every mutation, so the archive is made here.
void FuzzSog(std::string_view bytes) {
  static const ScratchFolder folder;
  const bool is_zipped = bytes.starts_with("PK");
  const std::string path = folder.Write("splat.sog", is_zipped ? std::string(bytes) : Bundle(bytes));
  gs::SplatModel model;
  if (!Reads(path, [&] { model = gs::ReadSog(path); })) return;
  PromiseSplat(model);
  constexpr Index kMostWritten = 1000;  // so that a run is short
  if (model.count <= kMostWritten) PromiseItSurvives(model, folder / "copy.sog", gs::WriteSog);
}

}  // namespace vesta::fuzz
