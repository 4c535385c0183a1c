// SPDX-License-Identifier: Apache-2.0
// The Jacobian of a view's raster pass, kept: the choice of 3DGS-LM (Höllein et al. 2025, section 3.3), for the
// products of one linearisation.
#pragma once

#include "kernels/core/buffer.h"
#include "kernels/gaussian_splatting/cache/cache_kernels.h"
#include "kernels/gaussian_splatting/tiles/tiles.h"

namespace vesta::splat {

// One entry for each pixel and splat that is part of it: four numbers (cache_passes.h), 16 bytes of float or 8 as 16
// bits each, and in place of an index the 256-bit mask of each pair of splat and tile: at the 50 to 80 pixels that a
// pair has, half a byte an entry where an index takes four, and the mask also is what spreads packed entries over the
// lanes of a vector. Entries lie splat by splat in the order of depth, within a splat tile by tile, within a tile row
// by row; how many there are is counted before memory is asked for.
//
// Products are those of the recomputing passes, but for rounding (kFull), or with each entry of the raster's Jacobian
// off by at most 2^-10 of itself and 2.4e-7 of the splat's share of the pixel (kHalf). J v and J^T u are adjoint to
// rounding in either. All parallel; bit-identical for any number of threads.
template <class S>
class JacobianCache {
 public:
  explicit JacobianCache(Isa isa = ActiveIsa()) : isa_(isa) {}

  // Replaces what was kept. lists and bins must be the same in the products; image: of those lists.
  void Build(const TileLists<S>& lists, const TileBins& bins, const S* image, CacheFormat format);
  // Frees the memory.
  void Clear() { *this = JacobianCache(isa_); }
  bool empty() const { return kernels_ == nullptr; }
  Index num_entries() const { return num_entries_; }
  Index num_bytes() const;
  // What num_bytes will be.
  static Index NumBytes(Index num_entries, Index num_pairs, CacheFormat format);

  // d_image = J_raster tangents, by rank.
  void Tangent(const TileLists<S>& lists, const TileBins& bins, const SplatTangent<S>* tangents, S* d_image) const;
  // sums[rank] = J_raster^T u. u_tiles: memory to work in, resized as needed.
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
