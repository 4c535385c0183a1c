// SPDX-License-Identifier: Apache-2.0
// COLMAP's mapper writes several models if it cannot connect all photographs. The largest becomes the scene.
#pragma once

#include <cstddef>
#include <string>

#include "apps/reconstruct/progress_file.h"

namespace vesta::app {

// Folders with a cameras.bin or cameras.txt.
std::size_t CountModels(const std::string& models);

struct ReconstructedScene {
  std::size_t registered = 0;  // photographs in the model
  std::size_t points = 0;
  std::size_t models = 0;  // by COLMAP
  double error = 0;        // mean reprojection error of the points, in pixels
};

// Copies the model with the most photographs (then the most points) to SCENE/sparse/0, unless it is there already. All
// its files appear at once. Throws Error if there is no readable model, or if the folder cannot be written.
ReconstructedScene WriteLargestModel(const ReconstructionPaths& paths);

}  // namespace vesta::app
