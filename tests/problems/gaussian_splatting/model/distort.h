// SPDX-License-Identifier: Apache-2.0
// Photographs as a distorting lens would have taken them, made from those of a pinhole, for tests that undistort them
// again.
#pragma once

#include <array>
#include <optional>

#include "problems/gaussian_splatting/scene/distortion.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs::test {

// The inverse of Distort: where a pinhole of focal length 1 sees what the lens sees at (x, y). By Newton's method
// along the way from the axis. None where the lens folds on that way.
std::optional<std::array<double, 2>> Undistort(const Distortion& lens, double x, double y);

// The camera with the same focal lengths and that lens whose image, of the shape of the pinhole's, is as large as the
// pinhole sees all of it. Throws Error where that is nothing.
Camera DistortedCamera(const Camera& pinhole, const Distortion& lens);

// The image of the pinhole as such a camera sees it; cubic interpolation, clamped to 0..1.
Image DistortImage(const Image& image, const Camera& pinhole, const Camera& camera, const Distortion& lens);

}  // namespace vesta::gs::test
