// SPDX-License-Identifier: Apache-2.0
// What holds of every scene that a reader lets pass.
#pragma once

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::fuzz {

// Cameras that can project, rotations, poses and points that are finite, colours in 0..1, an extent above zero. Throws
// Finding.
void PromiseScene(const gs::Scene& scene);

}  // namespace vesta::fuzz
