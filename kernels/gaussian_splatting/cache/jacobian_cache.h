// SPDX-License-Identifier: Apache-2.0
// Cached Jacobian of a view's raster pass (image as a function of the splats), for the products of one linearisation,
// as in 3DGS-LM (Höllein et al. 2025, section 3.3).
#pragma once

#include "kernels/core/buffer.h"
#include "kernels/gaussian_splatting/cache/cache_kernels.h"
#include "kernels/gaussian_splatting/tiles/tiles.h"

namespace vesta::splat {

// The cache has one entry for each pixel and each splat that contributes to it. An entry is four numbers
// (cache_entry.h): 16 bytes as float or 8 bytes in 16-bit format. Entries are ordered by splat (in depth order), then
// by tile and row. Instead of indices, each (splat, tile) pair stores a mask of the 256 pixels. A pair typically has 50
// to 80 entries, so the mask takes half a byte per entry.
//
// With kFull, products equal those without a cache (RasterKernels) up to rounding. With kHalf, the error of each entry
// of the raster's Jacobian is at most 2^-10 times the entry plus 2.4e-7 times the splat's weight in the pixel. In both
// formats, J v and J^T u are adjoint up to rounding. Results are bit-identical for any number of threads.
template <class S>
class JacobianCache {
 public:
  explicit JacobianCache(Isa isa = ActiveIsa()) : isa_(isa) {}

  // Computes the Jacobian and discards a previous one. Tangent and Adjoint need the same lists and bins. image:
  // rendered from the lists.
  void Build(const TileLists<S>& lists, const TileBins& bins, const S* image, CacheFormat format);
  void Clear() { *this = JacobianCache(isa_); }
  bool empty() const { return kernels_ == nullptr; }
  Index num_entries() const { return num_entries_; }
  Index num_bytes() const;
  // The value of num_bytes for these numbers of entries and (splat, tile) pairs.
  static Index NumBytes(Index num_entries, Index num_pairs, CacheFormat format);

  // d_image = J_raster tangents. tangents: by rank, the index of a splat in depth order.
  void Tangent(const TileLists<S>& lists, const TileBins& bins, const SplatTangent<S>* tangents, S* d_image) const;
  // sums[rank] = J_raster^T u. u_tiles: scratch memory, resized as needed.
  void Adjoint(const TileLists<S>& lists, const TileBins& bins, const S* u, SplatTangent<S>* sums,
               HostBuffer<S>& u_tiles) const;

 private:
  CacheLists Lists(const TileBins& bins) const;

  Isa isa_;
  const CacheKernels<S>* kernels_ = nullptr;
  HostBuffer<TileMask> masks_;
  HostBuffer<std::int64_t> first_entry_;
  HostBuffer<std::byte> entries_;
  Index num_entries_ = 0;
};

}  // namespace vesta::splat
