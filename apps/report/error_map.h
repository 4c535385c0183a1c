// Where a render differs from its photograph, as figures and as a picture.
#pragma once

#include "problems/gaussian_splatting/scene/image.h"

namespace vesta::app {

// The error from which on the picture is brightest: mean over channels of |render - truth|, colours in 0..1.
inline constexpr double kBrightestError = 0.25;

// A colour for each pixel, from black (no error) by red to pale yellow (kBrightestError and more). Both images, of one
// size, count as 8 bits hold them.
gs::Image ErrorMap(const gs::Image& render, const gs::Image& truth);

// The least part of the pixels, 0..1, that has half of the squared error: small where the error is in few places, near
// a half where it is everywhere. 0 for equal images.
double PartWithHalfOfError(const gs::Image& render, const gs::Image& truth);

}  // namespace vesta::app
