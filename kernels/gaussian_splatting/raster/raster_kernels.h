// SPDX-License-Identifier: Apache-2.0
// Raster passes over single tiles, for the instruction set chosen at run time.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/raster/loss_of_change.h"

namespace vesta::splat {

// Images are planar: plane c of a width x height image begins at index c * width * height. A pair is a splat and a tile
// that it touches; pair arrays are indexed like lists.ranks. Every function writes only the pixels or pairs of its
// tile, so tiles may run in parallel. The rank of a splat is its index in depth order.
template <class S>
struct RasterKernels {
  // image = sum_k c_k alpha_k T_k + T_end background, over the splats k front to back. T_k is the transmittance in
  // front of splat k, and T_end the one behind the last splat.
  void (*forward)(const TileLists<S>& lists, int tile, S* image);
  // Computes the change of the image from the tangents of the splats, by rank.
  void (*tangent)(const TileLists<S>& lists, int tile, const SplatTangent<S>* tangents, S* d_image);
  // Does both with bit-identical results. This is faster, because the blending weights are shared.
  void (*forward_tangent)(const TileLists<S>& lists, int tile, const SplatTangent<S>* tangents, S* image, S* d_image);
  // For each pair of the tile, the cotangent of its splat from the pixels of the tile. u: cotangent of the image.
  // image: from forward.
  void (*adjoint)(const TileLists<S>& lists, int tile, const S* image, const S* u, SplatTangent<S>* pair_sums);
  // For each pair of the tile, the Gram sums (splat_sums.h) with the weights omega >= 0 (3 planes). image: from
  // forward.
  void (*gram)(const TileLists<S>& lists, int tile, const S* image, const S* omega, SplatGram<S>* pair_sums);
  // For each pair of the tile, the rise of the loss in the tile if the pair's splat is removed (may be negative).
  void (*removal)(const TileLists<S>& lists, int tile, const LinearizedLoss<S>& loss, S* pair_rises);
  // For each pair of the tile, the second derivative of the loss with respect to the colour of its splat.
  void (*color_curvature)(const TileLists<S>& lists, int tile, const LinearizedLoss<S>& loss,
                          ColorCurvature<S>* pair_sums);
  // For each pair of the tile, the rise of the loss if its splat has other colours. recolors: by rank.
  void (*recolor)(const TileLists<S>& lists, int tile, const LinearizedLoss<S>& loss, const Recolors<S>* recolors,
                  RecolorRises<S>* pair_sums);
  // Counts the visited pairs, vectors and pixels. They are the same for all passes above.
  VisitCounts (*count)(const TileLists<S>& lists, int tile);
};

// S = float: SIMD over pixels. S = double: one pixel at a time from the same source, the reference in tests.
template <class S>
const RasterKernels<S>& GetRasterKernels();
// The float kernels of `isa`, which the CPU must support.
const RasterKernels<float>& FloatRasterKernelsFor(Isa isa);

// The median splat of a pixel is the splat at which the transmittance falls below one half. Writes the three colour
// components of values[rank of the median splat] to the pixel in the three planes, or 0 without a median splat. Writes
// only the pixels of its tile.
template <class S>
using MedianKernel = void (*)(const TileLists<S>& lists, int tile, const SplatTangent<S>* values, S* planes);

// S = double is the reference in tests.
template <class S>
MedianKernel<S> GetMedianKernel();
MedianKernel<float> FloatMedianKernelFor(Isa isa);

}  // namespace vesta::splat
