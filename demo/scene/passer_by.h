// SPDX-License-Identifier: Apache-2.0
// Paints a person who walks through the image, as a distractor that needs a mask.
#pragma once

#include <cstdint>

#include "problems/gaussian_splatting/scene/image.h"

namespace vesta::demo {

// Paints a person over the image, at a position and in a colour drawn from the random stream. Returns the mask, of the
// same size: black at the figure and in a margin around it of 1/60 of the image width, white elsewhere.
gs::Image PaintPasserBy(gs::Image* image, std::uint64_t stream);

}  // namespace vesta::demo
