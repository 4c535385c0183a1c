// SPDX-License-Identifier: Apache-2.0
// The demo scene as files, in COLMAP's layout.
#pragma once

#include <cstdint>
#include <string>

#include "problems/gaussian_splatting/scene/distortion.h"

namespace vesta::demo {

enum class Round {
  kRings,  // CameraPath: from low and high in turn
  kWalk,   // Walk: as a film
};

struct DemoOptions {
  int views = 40;                 // 2..9999
  int width = 200, height = 150;  // pixels, 8..4096
  int points = 3000;              // 1..1000000
  std::uint64_t seed = 0;
  Round round = Round::kRings;
  gs::Distortion lens = {};  // no fisheye, without k3 to k6; one to one on the image
  int passer_by_every = 0;   // somebody walks through each Nth picture; 0: nobody. 0..9999
};

// Takes the pictures and writes FOLDER/images/view_NNNN.png and the binary model FOLDER/sparse/0; of pictures with
// somebody in them masks too, FOLDER/masks/view_NNNN.png.png, black where they are. Throws Error when an option is out
// of range or the folder cannot be written.
void WriteDemoScene(const DemoOptions& options, const std::string& folder);

}  // namespace vesta::demo
