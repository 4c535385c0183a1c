// SPDX-License-Identifier: Apache-2.0
// Writes the demo scene in COLMAP's folder layout.
#pragma once

#include <cstdint>
#include <string>

#include "problems/gaussian_splatting/scene/distortion.h"

namespace vesta::demo {

enum class Round {
  kRings,  // CameraPath: alternately low and high
  kWalk,   // Walk: consecutive views, as in a film
};

struct DemoOptions {
  int views = 40;                 // 2..9999
  int width = 200, height = 150;  // pixels, 8..4096
  int points = 3000;              // 1..1000000
  std::uint64_t seed = 0;
  Round round = Round::kRings;
  gs::Distortion lens = {};  // no fisheye, without k3 to k6; must be invertible on the image
  int passer_by_every = 0;   // paint a person into every Nth image; 0: no person. 0..9999
};

// Renders the images and writes FOLDER/images/view_NNNN.png and the binary model FOLDER/sparse/0. For images with a
// person also writes FOLDER/masks/view_NNNN.png.png, which are black at the person. Throws Error if an option is out of
// range or the folder cannot be written.
void WriteDemoScene(const DemoOptions& options, const std::string& folder);

}  // namespace vesta::demo
