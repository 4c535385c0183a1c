// SPDX-License-Identifier: Apache-2.0
// Raster passes over single tiles, for the instruction set chosen at run time.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/raster/loss_of_change.h"

namespace vesta::splat {

// Images are planar: plane c of a width x height image begins at c * width * height. Every function reads and writes
// the pixels of its tile only, or the pairs (entries of lists.ranks) of its tile only, so tiles may run in parallel.
template <class S>
struct RasterKernels {
  // image = sum_k c_k alpha_k T_k + T_end background.
  void (*forward)(const TileLists<S>& lists, int tile, S* image);
  // d_image for the splat tangents, by rank.
  void (*tangent)(const TileLists<S>& lists, int tile, const SplatTangent<S>* tangents, S* d_image);
  // Both, with the same bits, for less than the price of one after the other: they weigh every splat alike.
  void (*forward_tangent)(const TileLists<S>& lists, int tile, const SplatTangent<S>* tangents, S* image, S* d_image);
  // For each pair of the tile the cotangent of its splat, given the cotangent u of the image. image: from forward.
  void (*adjoint)(const TileLists<S>& lists, int tile, const S* image, const S* u, SplatTangent<S>* pair_sums);
  // For each pair of the tile the Gram sums under the non-negative weights omega (3 planes).
  void (*gram)(const TileLists<S>& lists, int tile, const S* image, const S* omega, SplatGram<S>* pair_sums);
  // For each pair of the tile the rise of the loss without its splat; negative where that is better.
  void (*removal)(const TileLists<S>& lists, int tile, const LinearizedLoss<S>& loss, S* pair_rises);
  // For each pair of the tile the curvature of the loss by the colour of its splat.
  void (*color_curvature)(const TileLists<S>& lists, int tile, const LinearizedLoss<S>& loss,
                          ColorCurvature<S>* pair_sums);
  // For each pair of the tile what it gains or loses where its splat has other colours; recolors: by rank.
  void (*recolor)(const TileLists<S>& lists, int tile, const LinearizedLoss<S>& loss, const Recolors<S>* recolors,
                  RecolorRises<S>* pair_sums);
  // What each of these visits.
  VisitCounts (*count)(const TileLists<S>& lists, int tile);
};

// S = float: SIMD over pixels. S = double: one pixel at a time, from the same source; the reference of the tests.
template <class S>
const RasterKernels<S>& GetRasterKernels();
// The float kernels of a named instruction set, which the CPU must have: for the dispatch, and for tests that compare
// one set with another.
const RasterKernels<float>& FloatRasterKernelsFor(Isa isa);

// Three planes of the colours in `values`, by rank: in each pixel those of the splat at which the transmittance falls
// below one half, 0 where none is. Writes the pixels of its tile only.
template <class S>
using MedianKernel = void (*)(const TileLists<S>& lists, int tile, const SplatTangent<S>* values, S* planes);

// S = double is the reference of the tests.
template <class S>
MedianKernel<S> GetMedianKernel();
MedianKernel<float> FloatMedianKernelFor(Isa isa);

}  // namespace vesta::splat
