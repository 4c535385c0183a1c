// SPDX-License-Identifier: Apache-2.0
// Somebody who walks through the picture.
#pragma once

#include <cstdint>

#include "problems/gaussian_splatting/scene/image.h"

namespace vesta::demo {

// Paints the figure of a person over the image, at a place and in a colour of the stream's. Gives its mask: of the
// image's size, black where the figure is, with a margin of a sixtieth of the width, and white elsewhere.
gs::Image PaintPasserBy(gs::Image* image, std::uint64_t stream);

}  // namespace vesta::demo
