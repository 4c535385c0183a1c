// SPDX-License-Identifier: Apache-2.0
// Two cameras, three images and four points: the unchanged files of the COLMAP target, and its seeds.
#pragma once

#include "splatting/io/scenes/colmap.h"

namespace vesta::fuzz {

inline gs::ColmapModel SeedModel() {
  gs::ColmapModel model;
  model.cameras = {{1, gs::ColmapCameraModel::kPinhole, {60, 40, {61, 62.5, 30.5, 19.75}}, {}},
                   {2, gs::ColmapCameraModel::kSimplePinhole, {30, 20, {30, 30, 15, 10}}, {}}};
  for (std::uint32_t i = 0; i < 3; ++i) {
    model.images.push_back({i, {1, 0.1 * i, 0, 0}, {0.5 * i, 0, 4}, 1 + i % 2, "view" + std::to_string(i) + ".png"});
  }
  for (std::uint64_t i = 0; i < 4; ++i) {
    const double x = static_cast<double>(i);
    model.points.push_back({i, {0.3 * x - 0.4, 0.1 * x, 0.2 * x}, {200, static_cast<std::uint8_t>(60 * i), 30}, 0.5});
  }
  return model;
}

}  // namespace vesta::fuzz
