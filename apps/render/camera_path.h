// SPDX-License-Identifier: Apache-2.0
// The cameras that --path names.
#pragma once

#include <string>
#include <vector>

#include "apps/cli/flags.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

struct CameraPath {
  std::vector<gs::View> views;  // in the frame of the scene, without images
  std::string note;             // a line for the user, or none
};

// Throws UsageError where flags of render do not go together or are none, before anything is read.
void CheckPathFlags(const Flags& flags);

// With --path. Cameras are that of the scene's first view, or those of the file, each of --size where that is given:
// then the middle of what it sees. Throws Error, one line with flag or file.
CameraPath PathOfFlags(const Flags& flags, const gs::Scene& scene);

}  // namespace vesta::app
