// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "splatting/io/splats/ply.h"
#include "tests/fuzz/promise.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {

void FuzzPointPly(std::string_view bytes) {
  static const ScratchFolder folder;
  const std::string path = folder.Write("points.ply", bytes);
  gs::WorldPoints points;
  if (!Reads(path, [&] { points = gs::ReadPointPly(path); })) return;
  Promise(!points.positions.empty() && points.positions.size() == points.colors.size(), "no points");
  for (const auto& position : points.positions) {
    for (const double value : position) Promise(std::isfinite(value), "a point that is not finite");
  }
  for (const auto& color : points.colors) {
    for (const float channel : color) Promise(channel >= 0 && channel <= 1, "a colour outside 0..1");
  }
}

}  // namespace vesta::fuzz
