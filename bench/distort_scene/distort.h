// Photographs as a distorting lens would have taken them, made from those of a pinhole: for measuring what is lost when
// they are undistorted again.
#pragma once

#include <array>
#include <optional>

#include "problems/gaussian_splatting/model/distortion.h"
#include "problems/gaussian_splatting/model/scene.h"

namespace vesta::bench {

// The inverse of gs::Distort: where a pinhole of focal length 1 sees what the lens sees at (x, y). By Newton's method
// along the way from the axis. None where the lens folds on that way.
std::optional<std::array<double, 2>> Undistort(const gs::Distortion& lens, double x, double y);

// The camera with the same focal lengths and that lens whose image, of the shape of the pinhole's, is as large as the
// pinhole sees all of it. Throws Error where that is nothing.
gs::Camera DistortedCamera(const gs::Camera& pinhole, const gs::Distortion& lens);

// The image of the pinhole as such a camera sees it; cubic interpolation, clamped to 0..1.
gs::Image DistortImage(const gs::Image& image, const gs::Camera& pinhole, const gs::Camera& camera,
                       const gs::Distortion& lens);

}  // namespace vesta::bench
