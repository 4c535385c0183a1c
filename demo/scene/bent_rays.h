// SPDX-License-Identifier: Apache-2.0
// Inverse lens distortion: computes the undistorted ray of a position in a distorted image.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "problems/gaussian_splatting/scene/distortion.h"

namespace vesta::demo {

// Solves Distort(lens, x, y) = (u, v) for normalised coordinates (x, y) = (x/z, y/z) near the axis with Newton's
// method, to 1e-12. Returns nullopt if there is no solution, as beyond the circle where the distortion folds.
std::optional<std::array<double, 2>> Undistort(const gs::Distortion& lens, double u, double v);

// Parses "k1", "k1,k2" or "k1,k2,p1,p2"; "" is a pinhole. Throws an Error that names --lens for any other text.
gs::Distortion ParseLens(const std::string& text);

}  // namespace vesta::demo
