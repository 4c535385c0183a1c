// SPDX-License-Identifier: Apache-2.0
// Resamples photographs of lenses with distortion to images of pinhole cameras.
#pragma once

#include <array>
#include <optional>

#include "problems/gaussian_splatting/scene/distortion.h"
#include "problems/gaussian_splatting/scene/image.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// The colour and transparency (r, g, b, t) at (u, v), in pixels; pixel (i, j) has its centre at (i + 0.5, j + 0.5).
// Catmull-Rom cubic interpolation: it passes through the pixels and is exact where colours change linearly. Not clamped
// to 0..1. The border pixel is repeated beyond the border.
std::array<float, 4> SampleCubic(const Image& image, double u, double v);

// True if (u, v) is in the image and Image::mask includes the four pixels around it, which have nearly all the weight
// in the interpolation.
bool IsUnmaskedAround(const Image& image, double u, double v);

// The pinhole camera for the undistorted image. It keeps the focal lengths, so the resolution at the centre is the
// same. Its image is the largest rectangle inside the photograph (like `colmap image_undistorter` with blank_pixels =
// 0) where the lens is one-to-one, at most twice as wide and high. Returns nullopt if less than a fifth of the width or
// height would remain (a bad calibration), or if a coefficient is not finite. Without distortion, returns `camera`.
std::optional<Camera> PinholeOf(const Camera& camera, const Distortion& lens);

// Resamples the photograph of `camera` to the image of `pinhole` (from PinholeOf), which has the same pose. A pixel is
// a Catmull-Rom sample, clamped to 0..1. Where the image shrinks, a pixel is the mean of up to 8 x 8 samples, at most
// one photograph pixel apart. The mask includes a pixel if IsUnmaskedAround is true for all its samples. `image` must
// have the size of `camera`.
Image UndistortImage(const Image& image, const Camera& camera, const Distortion& lens, const Camera& pinhole);

}  // namespace vesta::gs
