// SPDX-License-Identifier: Apache-2.0
// What the Adam stage trains on at its start.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// The size of a view's coarse image: half of it, or all of it where a half would have a side of fewer than 64 pixels.
ImageSize CoarseSize(const View& view);

// The views with images and cameras of CoarseSize; empty where all of them would stay as they are. An iteration at half
// size takes about a third of the time and its step is as long, so large structures are in place sooner
// (docs/decisions/half-resolution-start.md).
std::vector<View> CoarseViews(const std::vector<const View*>& views);

// What a view's pull at the splats (density_steps.h) is divided by when the view is `width` pixels wide instead of
// `full_width`. Fine detail is missing at half size, and pulls are smaller. With this factor half-size views make as
// many Gaussians as full-size views, or up to a third more (docs/decisions/half-resolution-start.md).
inline double PullShare(int width, int full_width) { return width < full_width ? 0.6 : 1.0; }

}  // namespace vesta::gs
