// SPDX-License-Identifier: Apache-2.0
// Photographs of distorting lenses resampled as those of pinholes.
#pragma once

#include <array>
#include <optional>

#include "problems/gaussian_splatting/scene/distortion.h"
#include "problems/gaussian_splatting/scene/image.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// The colour at pixel coordinates (u, v), where pixel (i, j) has its centre at (i + 0.5, j + 0.5): the cubic
// interpolation of Catmull and Rom, not clamped. It passes through the pixels and is exact where colours change
// linearly. Beyond the border stands the pixel of the border.
std::array<float, 3> SampleCubic(const Image& image, double u, double v);

// Whether (u, v) lies in the image and the four pixels about it, which make up nearly all of that colour, take part
// (Image::mask).
bool CountsAbout(const Image& image, double u, double v);

// The pinhole camera that stands for this one: the same focal lengths, so that the middle keeps its resolution, and as
// large an image about the optical axis as has all its pixels within the distorted one (as `colmap image_undistorter`
// with blank_pixels = 0), to twice as wide and high. It keeps to where the lens is one to one. None where less than a
// fifth of the width or height would remain (of such a calibration nothing is meant), or the coefficients are not
// finite. Of a lens without distortion: the camera itself.
std::optional<Camera> PinholeOf(const Camera& camera, const Distortion& lens);

// The image of `camera` with that lens, as `pinhole` sees it from the same place. Cubic interpolation (Catmull-Rom,
// clamped to 0..1); where the image shrinks, the mean of samples at most one of its pixels apart. A
// pixel takes part where the four about each of its samples do. The image has the
// camera's size.
Image UndistortImage(const Image& image, const Camera& camera, const Distortion& lens, const Camera& pinhole);

}  // namespace vesta::gs
