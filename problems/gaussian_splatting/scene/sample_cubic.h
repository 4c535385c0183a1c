// Images between their pixels.
#pragma once

#include <array>

#include "problems/gaussian_splatting/scene/image.h"

namespace vesta::gs {

// The colour at pixel coordinates (u, v), where pixel (i, j) has its centre at (i + 0.5, j + 0.5): the cubic
// interpolation of Catmull and Rom, not clamped. It passes through the pixels and is exact where colours change
// linearly. Beyond the border stands the pixel of the border.
std::array<float, 3> SampleCubic(const Image& image, double u, double v);

// Whether (u, v) lies in the image and the four pixels about it, which make up nearly all of that colour, take part
// (Image::mask).
bool CountsAbout(const Image& image, double u, double v);

}  // namespace vesta::gs
