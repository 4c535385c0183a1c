// SPDX-License-Identifier: Apache-2.0
// Paints a person into an image, which moves between photographs and must be masked.
#pragma once

#include <cstdint>

#include "problems/gaussian_splatting/scene/image.h"

namespace vesta::demo {

// Position and colours are random and depend only on `stream` (random.h). Returns the mask, of the same size: black at
// the person and up to 1/60 of the image width around, white elsewhere.
gs::Image PaintPasserBy(gs::Image* image, std::uint64_t stream);

}  // namespace vesta::demo
