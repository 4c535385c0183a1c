// SPDX-License-Identifier: Apache-2.0
// Masks of photographs: which of their pixels take part.
#pragma once

#include <string>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// Finds the masks of the views in the folder masks/ (or mask/) of the scene: NAME.png (as COLMAP names them, of
// a/b.jpg: a/b.jpg.png), else NAME with .png in place of its extension. A view that names one already
// (View::mask_path) keeps it. Adds a note on how many views have one, and where the folder has none of any.
void FindMasks(const std::string& scene_folder, Scene* scene);

// Takes the pixels out of the photograph that are black in the mask, as COLMAP does; a mask of another size is taken at
// the nearest pixel. Throws Error, one line that names the mask, where it cannot be read, has another aspect ratio, or
// leaves nothing of the photograph. Returns the bytes that it held meanwhile.
double ApplyMask(const std::string& mask_path, Image* photograph);

}  // namespace vesta::gs
