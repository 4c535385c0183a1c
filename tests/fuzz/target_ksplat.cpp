// SPDX-License-Identifier: Apache-2.0
#include <cstring>

#include "splatting/io/splats/splat_file.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/splat_promise.h"
#include "tests/fuzz/targets.h"
#include "tests/splatting/io/ksplat_parts.h"

namespace vesta::fuzz {

// Adds the unused bytes of the headers, because the inputs are short.
void FuzzKsplat(std::string_view bytes) {
  static const ScratchFolder folder;
  const auto take = [&](std::size_t used, std::size_t size) {
    std::string part(bytes.substr(0, used));
    bytes.remove_prefix(part.size());
    part.resize(size);
    return part;
  };
  std::string file = take(gs::kKsplatHeaderUsed, gs::kKsplatHeader);
  std::uint32_t sections = 0;
  std::memcpy(&sections, file.data() + 4, sizeof(sections));
  for (; sections > 0 && !bytes.empty(); --sections) file += take(gs::kKsplatSectionUsed, gs::kKsplatSectionHeader);
  file += bytes;
  const std::string path = folder.Write("fuzzed.ksplat", file);
  gs::SplatModel model;
  if (Reads(path, [&] { model = gs::ReadSplat(path); })) PromiseSplat(model);
}

}  // namespace vesta::fuzz
