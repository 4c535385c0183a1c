// SPDX-License-Identifier: Apache-2.0
// Undistortion: resamples photographs of lenses with distortion to images of pinhole cameras.
#pragma once

#include <array>
#include <optional>

#include "problems/gaussian_splatting/scene/distortion.h"
#include "problems/gaussian_splatting/scene/image.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// Returns the colour (r, g, b) at image position (u, v), in pixels; pixel (i, j) has its centre at (i + 0.5, j + 0.5).
// Catmull-Rom cubic interpolation: it passes through the pixels and is exact where colours change linearly. The result
// is not clamped to 0..1. Beyond the border, the border pixel is repeated.
std::array<float, 3> SampleCubic(const Image& image, double u, double v);

// True if (u, v) is in the image and Image::mask does not exclude any of the four pixels around it. These pixels have
// nearly all the weight in the interpolation.
bool IsUnmaskedAround(const Image& image, double u, double v);

// Returns the pinhole camera for the undistorted image of a camera with this lens. The focal lengths are the same, so
// the resolution at the centre is the same. The undistorted image is the largest rectangle whose pixels are all inside
// the photograph (like `colmap image_undistorter` with blank_pixels = 0), up to twice its width and height. It covers
// only the region in which the lens is one-to-one. Returns nullopt if less than a fifth of the width or height would
// remain, which indicates a bad calibration, or if a coefficient is not finite. Without distortion, returns `camera`.
std::optional<Camera> PinholeOf(const Camera& camera, const Distortion& lens);

// Resamples the photograph of `camera` with this lens to the image of `pinhole` (from PinholeOf), which has the same
// pose. A pixel is a Catmull-Rom sample, clamped to 0..1. Where the image shrinks, it is the mean of up to 8 x 8
// samples, at most one photograph pixel apart. The mask of the result includes a pixel if IsUnmaskedAround is true for
// all its samples. `image` must have the size of `camera`.
Image UndistortImage(const Image& image, const Camera& camera, const Distortion& lens, const Camera& pinhole);

}  // namespace vesta::gs
