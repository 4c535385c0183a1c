// SPDX-License-Identifier: Apache-2.0
// Distorting lenses the other way round: where a ray comes from that the lens shows at a place of the image.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "problems/gaussian_splatting/scene/distortion.h"

namespace vesta::demo {

// The (x, y) = (x/z, y/z) near the axis with Distort(lens, x, y) = (u, v), to 1e-12, by Newton's method. None where
// there is none, as beyond the circle where a lens folds.
std::optional<std::array<double, 2>> Undistort(const gs::Distortion& lens, double u, double v);

// "k1", "k1,k2" or "k1,k2,p1,p2"; a pinhole of "". Throws Error, which names --lens, of anything else.
gs::Distortion ParseLens(const std::string& text);

}  // namespace vesta::demo
