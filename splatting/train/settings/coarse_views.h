// SPDX-License-Identifier: Apache-2.0
// Half-size views for the start of the Adam stage.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// Half, or full size if a half-size side would have fewer than 64 pixels.
ImageSize CoarseSize(const View& view);

// The views at CoarseSize; empty if that is the full size for all. Their dilation
// (Camera::eps2d) has the size in the scene that it has at full size, so that a splat that fits half-size photographs
// is also right at full size. A half-size iteration takes about a third of the
// time, and Adam's step has the same length. So large structures appear sooner
// (docs/decisions/half-resolution-start.md).
std::vector<View> CoarseViews(const std::vector<const View*>& views);

}  // namespace vesta::gs
