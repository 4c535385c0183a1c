// SPDX-License-Identifier: Apache-2.0
// What stands in a pixel where half of the light is gone, for the instruction set chosen at run time.
#pragma once

#include "kernels/gaussian_splatting/formulas/types.h"

namespace vesta::splat {

// Three planes of the colours in `values`, by rank: in each pixel those of the splat at which the transmittance falls
// below one half, 0 where none is. Writes the pixels of its tile only.
template <class S>
using MedianKernel = void (*)(const TileLists<S>& lists, int tile, const SplatTangent<S>* values, S* planes);

// S = double is the reference of the tests.
template <class S>
MedianKernel<S> GetMedianKernel();

}  // namespace vesta::splat
