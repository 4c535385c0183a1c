// Names of files that a scene's own files give.
#pragma once

#include <filesystem>
#include <string>

namespace vesta::gs {

// Whether a name, as from `folder` within the scene, leads out of the scene: what others have written must not be a way
// to files elsewhere.
inline bool LeavesScene(const std::string& folder, const std::string& name) {
  const std::filesystem::path path = (std::filesystem::path(folder) / name).lexically_normal();
  return path.is_absolute() || (!path.empty() && *path.begin() == "..");
}

}  // namespace vesta::gs
