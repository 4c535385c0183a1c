// SPDX-License-Identifier: Apache-2.0
// The exposure that brings one image to another.
#pragma once

#include "kernels/image/image_shape.h"
#include "kernels/image/loss_options.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// Minimises the photometric loss of the rendered image, its exposure changed, by Levenberg-Marquardt from none. Not by
// squares: a splat's image is off by more than noise, and least squares answer that with too little contrast. Both
// images planar and of that shape; mask: which pixels count (Image::mask). What nothing tells of stays as it is, and
// all does where an image is not finite. The same bits for any number of threads.
AffineColor FitExposure(HostSpan<const float> rendered, HostSpan<const float> truth, const ImageShape& shape,
                        const PhotometricWeights& weights = {}, HostSpan<const std::uint8_t> mask = {});

}  // namespace vesta::gs
