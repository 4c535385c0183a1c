// The folder of a scene, as commands take it and tell of it.
#pragma once

#include <string>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// Throws Error where there is no such folder.
void CheckSceneFolder(const std::string& path);

// How many views and points were loaded, and what is odd about them.
void PrintScene(const gs::Scene& scene);

}  // namespace vesta::app
