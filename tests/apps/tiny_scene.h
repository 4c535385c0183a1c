// SPDX-License-Identifier: Apache-2.0
// A scene so small that it trains within a second.
#pragma once

#include <string>

#include "splatting/io/scenes/colmap.h"

namespace vesta::test {

inline constexpr int kTinyViews = 10;  // 2 of them test views: 000.png and 008.png
inline constexpr int kTinyWidth = 32, kTinyHeight = 24;

// One camera, views on an arc around the origin, and points near the origin.
gs::ColmapModel TinyModel();

// Writes SCENE/images/NNN.png and SCENE/sparse/0 (binary).
void WriteTinyScene(const std::string& scene, const gs::ColmapModel& model = TinyModel());

}  // namespace vesta::test
