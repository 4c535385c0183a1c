// SPDX-License-Identifier: Apache-2.0
// Simulates photographs of a distorting lens from a pinhole image, for tests of undistortion.
#pragma once

#include <array>
#include <optional>

#include "problems/gaussian_splatting/scene/distortion.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs::test {

// The inverse of Distort: where a pinhole of focal length 1 sees the point that the lens shows at (x, y). Uses Newton's
// method along the line from the axis. Returns nothing if the lens folds on that line.
std::optional<std::array<double, 2>> Undistort(const Distortion& lens, double x, double y);

// The camera with that lens, the same focal lengths and the shape of the pinhole's image. Its image is the largest that
// the pinhole covers completely, in steps of 1 %. Throws Error if no such image exists.
Camera DistortedCamera(const Camera& pinhole, const Distortion& lens);

// Renders the pinhole's image for such a camera, with cubic interpolation, clamped to 0..1.
Image DistortImage(const Image& image, const Camera& pinhole, const Camera& camera, const Distortion& lens);

}  // namespace vesta::gs::test
