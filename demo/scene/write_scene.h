// SPDX-License-Identifier: Apache-2.0
// Writes the demo scene in COLMAP's folder layout, as if reconstructed from photographs.
#pragma once

#include <cstdint>
#include <string>

#include "problems/gaussian_splatting/scene/distortion.h"

namespace vesta::demo {

// The camera path around the scene (camera_path.h).
enum class Round {
  kRings,  // CameraPath: cameras alternately low and high
  kWalk,   // Walk: consecutive frames, as in a film
};

struct DemoOptions {
  int views = 40;                 // 2..9999
  int width = 200, height = 150;  // pixels, 8..4096
  int points = 3000;              // points of the COLMAP model, 1..1000000
  std::uint64_t seed = 0;
  Round round = Round::kRings;
  gs::Distortion lens = {};  // only k1, k2, p1 and p2 may differ from 0; must be invertible on the image
  int passer_by_every = 0;   // a person in every Nth image, 0..9999; 0: none
};

// Writes FOLDER/images/view_NNNN.png and the binary COLMAP model FOLDER/sparse/0. Images with a person also have masks,
// FOLDER/masks/view_NNNN.png.png, black at the person and white elsewhere. Throws Error if an option is out of range or
// the folder cannot be written.
void WriteDemoScene(const DemoOptions& options, const std::string& folder);

}  // namespace vesta::demo
