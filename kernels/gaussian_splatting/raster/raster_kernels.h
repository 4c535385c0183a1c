// SPDX-License-Identifier: Apache-2.0
// Raster passes over single tiles, for the instruction set chosen at run time.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/raster/loss_of_change.h"

namespace vesta::splat {

// Images are planar: plane c of a width x height image begins at c * width * height. Every function reads and writes
// only the pixels, or the pairs (entries of lists.ranks), of its tile, so tiles may run in parallel.
template <class S>
struct RasterKernels {
  // image = sum_k c_k alpha_k T_k + T_end background.
  void (*forward)(const TileLists<S>& lists, int tile, S* image);
  // Computes d_image from the splat tangents, by rank.
  void (*tangent)(const TileLists<S>& lists, int tile, const SplatTangent<S>* tangents, S* d_image);
  // Computes both with bit-identical results, faster than separately because the blending weights are shared.
  void (*forward_tangent)(const TileLists<S>& lists, int tile, const SplatTangent<S>* tangents, S* image, S* d_image);
  // For each pair of the tile, the cotangent of its splat. u: cotangent of the image. image: from forward.
  void (*adjoint)(const TileLists<S>& lists, int tile, const S* image, const S* u, SplatTangent<S>* pair_sums);
  // For each pair of the tile, the Gram sums with the non-negative weights omega (3 planes).
  void (*gram)(const TileLists<S>& lists, int tile, const S* image, const S* omega, SplatGram<S>* pair_sums);
  // For each pair of the tile, the rise of the loss without its splat; negative if the loss falls.
  void (*removal)(const TileLists<S>& lists, int tile, const LinearizedLoss<S>& loss, S* pair_rises);
  // For each pair of the tile, the curvature of the loss with respect to its splat's colour.
  void (*color_curvature)(const TileLists<S>& lists, int tile, const LinearizedLoss<S>& loss,
                          ColorCurvature<S>* pair_sums);
  // For each pair of the tile, the rise of the loss if its splat has other colours. recolors: by rank.
  void (*recolor)(const TileLists<S>& lists, int tile, const LinearizedLoss<S>& loss, const Recolors<S>* recolors,
                  RecolorRises<S>* pair_sums);
  // Counts the work of each of these passes.
  VisitCounts (*count)(const TileLists<S>& lists, int tile);
};

// S = float: SIMD over pixels. S = double: one pixel at a time from the same source, as the reference in tests.
template <class S>
const RasterKernels<S>& GetRasterKernels();
// The float kernels of one instruction set, which the CPU must support.
const RasterKernels<float>& FloatRasterKernelsFor(Isa isa);

// Writes three planes: for each pixel the colour components of `values` (by rank) of the median splat, at which the
// transmittance falls below one half, or 0 if no splat does that. Writes only the pixels of its tile.
template <class S>
using MedianKernel = void (*)(const TileLists<S>& lists, int tile, const SplatTangent<S>* values, S* planes);

// S = double is the reference in tests.
template <class S>
MedianKernel<S> GetMedianKernel();
MedianKernel<float> FloatMedianKernelFor(Isa isa);

}  // namespace vesta::splat
