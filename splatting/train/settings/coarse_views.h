// SPDX-License-Identifier: Apache-2.0
// Views with half-size images, for the start of the Adam stage.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// The size of a view's coarse image: half, or full size if a half-size side would have fewer than 64 pixels.
ImageSize CoarseSize(const View& view);

// The views with images and cameras of CoarseSize; empty if this is the full size for all views. An iteration at half
// size takes about a third of the time, and Adam's step has the same length. Large structures therefore appear sooner
// (docs/decisions/half-resolution-start.md).
std::vector<View> CoarseViews(const std::vector<const View*>& views);

// Divisor of a view's image-space gradients (Grad2d, density_steps.h) for an image `width` pixels wide instead of
// `full_width`. Half-size images lack fine detail, so their gradients are smaller. After the division they lead to as
// many new Gaussians as full-size images do, or up to a third more (docs/decisions/half-resolution-start.md).
inline double HalfSizeGradScale(int width, int full_width) { return width < full_width ? 0.6 : 1.0; }

}  // namespace vesta::gs
