// A scene as a COLMAP model.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/scenes/colmap.h"

namespace vesta::gs {

// views: of the scene, wherever their cameras stand now, in the scene's frame. The model is in the world of the scene's
// files, with its points; one camera for each different one, of photographs that were undistorted that of their files.
ColmapModel ColmapOf(const Scene& scene, const std::vector<View>& views);

}  // namespace vesta::gs
