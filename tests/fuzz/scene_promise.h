// SPDX-License-Identifier: Apache-2.0
// The invariants of every scene that a reader accepts.
#pragma once

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::fuzz {

// Checks that cameras can project; rotations, poses and points are finite, colours in 0..1, and the extent positive.
// Throws Finding.
void PromiseScene(const gs::Scene& scene);

}  // namespace vesta::fuzz
