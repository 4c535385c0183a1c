// What the Adam stage trains on at its start.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/model/scene.h"

namespace vesta::gs {

// The views with images and cameras of half the size (DownscaledSize by 2), but for those whose half would have a side
// of fewer than 64 pixels, which stay as they are; none where that is so of all of them. Of an iteration a half takes
// about a third of the time, and steps are no shorter: what is large is in place sooner (docs/results).
std::vector<View> CoarseViews(const std::vector<const View*>& views);

// What part of its pull at the splats (screen_pull.h) a view keeps that is so wide instead of `full_width`: fine detail
// is gone from a half. Divided by it, halves at first make as many Gaussians as whole views do, or up to a third more
// (docs/results).
inline double PullShare(int width, int full_width) { return width < full_width ? 0.6 : 1.0; }

}  // namespace vesta::gs
