// SPDX-License-Identifier: Apache-2.0
// Inverse of lens distortion: the ray through a position in a distorted image.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "problems/gaussian_splatting/scene/distortion.h"

namespace vesta::demo {

// Returns (x, y) with Distort(lens, x, y) = (u, v), by Newton's method, to 1e-12, all in normalised coordinates (x/z
// and y/z in camera coordinates). Returns nullopt without a solution near the axis, for example outside the circle in
// which the distortion is one-to-one.
std::optional<std::array<double, 2>> Undistort(const gs::Distortion& lens, double u, double v);

// Parses --lens: "k1", "k1,k2" or "k1,k2,p1,p2"; "" means no distortion. Throws Error (one line with --lens) for any
// other text.
gs::Distortion ParseLens(const std::string& text);

}  // namespace vesta::demo
