// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>

#include "splatting/io/splats/spz.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/splat_promise.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {

// A few bytes of zstd can be many Gaussians, so files with many are left out.
void FuzzSpzStreams(std::string_view bytes) {
  constexpr std::uint32_t kMostGaussians = 1 << 15;
  constexpr std::size_t kCountAt = 8;
  std::uint32_t count = 0;
  if (bytes.size() >= kCountAt + sizeof(count)) std::memcpy(&count, bytes.data() + kCountAt, sizeof(count));
  if (count > kMostGaussians) return;
  static const ScratchFolder folder;
  const std::string path = folder.Write("streams.spz", bytes);
  gs::SplatModel model;
  if (!Reads(path, [&] { model = gs::ReadSpz(path); })) return;
  PromiseSplat(model);
  PromiseItSurvives(model, folder / "copy.spz",
                    [](const std::string& copy, const gs::SplatModel& splat) { gs::WriteSpz(copy, splat); });
}

}  // namespace vesta::fuzz
