// SPDX-License-Identifier: Apache-2.0
// Simulates photographs of a distorting lens from a pinhole image.
#pragma once

#include <array>
#include <optional>

#include "problems/gaussian_splatting/scene/distortion.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs::test {

// Inverse of Distort: where a pinhole of focal length 1 sees the point that the lens shows at (x, y). By Newton's
// method along the line from the axis. Nothing if the lens folds on that line.
std::optional<std::array<double, 2>> Undistort(const Distortion& lens, double x, double y);

// The camera with that lens, the same focal lengths and aspect ratio: the largest image that the pinhole covers, in
// steps of 1 %. Throws Error if there is no such image.
Camera DistortedCamera(const Camera& pinhole, const Distortion& lens);

// The image of such a camera, with cubic interpolation, clamped to 0..1.
Image DistortImage(const Image& image, const Camera& pinhole, const Camera& camera, const Distortion& lens);

}  // namespace vesta::gs::test
