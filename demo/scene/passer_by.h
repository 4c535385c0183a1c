// SPDX-License-Identifier: Apache-2.0
// Paints a person into a photograph of the demo scene. The person's position differs between photographs, so a training
// must mask the person.
#pragma once

#include <cstdint>

#include "problems/gaussian_splatting/scene/image.h"

namespace vesta::demo {

// stream: a hash (random.h) that determines the position and the colours of the person. Returns a mask with the size of
// the image. It is black at the person and in a margin of 1/60 of the image width around the person, and white
// elsewhere.
gs::Image PaintPasserBy(gs::Image* image, std::uint64_t stream);

}  // namespace vesta::demo
