// SPDX-License-Identifier: Apache-2.0
// Paints a person into an image: something that moves between photographs and must be masked.
#pragma once

#include <cstdint>

#include "problems/gaussian_splatting/scene/image.h"

namespace vesta::demo {

// Paints a person at a random position in random colours, which depend only on `stream` (random.h). Returns the mask,
// an image of the same size: black at the person and up to 1/60 of the image width around, white elsewhere.
gs::Image PaintPasserBy(gs::Image* image, std::uint64_t stream);

}  // namespace vesta::demo
