// SPDX-License-Identifier: Apache-2.0
// Points on surfaces, from photographs whose cameras are known, for scenes without points.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/span.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// At most `count` points on surfaces that several training views show, with the colours of their pixels, by plane sweep
// (Collins 1996, A Space-Sweep Approach to True Multi-Image Matching).
//
// Pixels are drawn at random, equally many in each training view. For each, the 5 x 5 pixels around it are projected
// into up to four other views at many depths, from an eighth of the likely depth (LikelyDepths) to infinity, and
// compared by normalized cross-correlation of the green channel. The score of a depth is the mean correlation of the
// two views that agree best. The best depth gives a point if its score is at least 0.7 and exceeds those of all other
// depths by 0.1. Images are compared at a size of at most 320 pixels. Masked pixels are not compared.
//
// Views need photographs. The result may be empty, for example for views without texture or overlap. Points are in the
// coordinates of the views, and bit-identical for any number of threads.
PointCloud PointsByPlaneSweep(const std::vector<View>& views, Index count, std::uint64_t seed);

}  // namespace vesta::gs
