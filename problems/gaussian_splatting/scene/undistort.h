// SPDX-License-Identifier: Apache-2.0
// Resamples photographs of distorting lenses for pinhole cameras.
#pragma once

#include <array>
#include <optional>

#include "problems/gaussian_splatting/scene/distortion.h"
#include "problems/gaussian_splatting/scene/image.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// The colour at pixel coordinates (u, v), where pixel (i, j) has its centre at (i + 0.5, j + 0.5). Catmull-Rom cubic
// interpolation, not clamped: it passes through the pixels and is exact where colours change linearly. Beyond the
// border, the border pixel is repeated.
std::array<float, 3> SampleCubic(const Image& image, double u, double v);

// True if (u, v) is in the image and the mask includes the four pixels around it, which have nearly all the weight
// (Image::mask).
bool CountsAbout(const Image& image, double u, double v);

// The pinhole camera that replaces this one. It keeps the focal lengths, so the centre keeps its resolution. Its image
// is the largest with all pixels inside the distorted one (like `colmap image_undistorter` with blank_pixels = 0), up
// to twice the width and height. It covers only the region in which the lens is one-to-one. Returns nothing if less
// than a fifth of the width or height would remain, which indicates a bad calibration, or if a coefficient is not
// finite. For a lens without distortion it returns the camera itself.
std::optional<Camera> PinholeOf(const Camera& camera, const Distortion& lens);

// Resamples the image of `camera` with that lens to the view of `pinhole` from the same place. Uses cubic interpolation
// (Catmull-Rom, clamped to 0..1); where the image shrinks, the mean of samples at most one photograph pixel apart (at
// most 8 x 8 samples). The mask includes a pixel if it includes the four pixels around each of its samples. The image
// must have the camera's size.
Image UndistortImage(const Image& image, const Camera& camera, const Distortion& lens, const Camera& pinhole);

}  // namespace vesta::gs
