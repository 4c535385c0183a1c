// SPDX-License-Identifier: Apache-2.0
// The Jacobian of a view's raster pass, kept in the memory of a GPU for the products of one linearisation.
#pragma once

#include "kernels/core/device_buffer.h"
#include "kernels/gaussian_splatting/cache/cache_blocks.h"

namespace vesta::splat {

// As JacobianCache, in float: 16 bytes of values an entry or 8, and for each pair of splat and tile its mask and where
// it lies, 64 bytes: at the 50 to 80 pixels that a pair has, about one byte an entry. Results are the same bits every
// time. All pointers are to memory of the GPU; products neither wait nor allocate.
class DeviceJacobianCache {
 public:
  // Replaces what was kept. lists and places, of as many pairs, must be the same in the products; places[k] is the
  // place of pair k of the lists in the order of splats. image: of those lists. Waits once, for the number of entries.
  // counts, temporary: memory to work in. Throws OutOfDeviceMemory, the cache being empty then.
  void Build(const TileLists<float>& lists, const std::uint32_t* places, Index pairs, const float* image,
             CacheFormat format, DeviceBuffer<Index>& counts, DeviceBuffer<unsigned char>& temporary);
  // Frees the memory.
  void Clear() { *this = DeviceJacobianCache(); }
  bool empty() const { return first_entry_.empty(); }
  Index num_entries() const { return num_entries_; }
  Index num_bytes() const { return empty() ? 0 : NumBytes(num_entries_, pairs_.size(), format_); }
  // Of a cache of so many entries and pairs.
  static constexpr Index NumBytes(Index entries, Index pairs, CacheFormat format) {
    const std::size_t entry = format == CacheFormat::kFull ? sizeof(CacheEntry<float>) : sizeof(CacheEntry<Half>);
    return entries * static_cast<Index>(entry) + pairs * static_cast<Index>(sizeof(CachePair)) +
           (pairs + 1) * static_cast<Index>(sizeof(Index));
  }

  // d_image = J_raster tangents, by rank.
  void Tangent(const TileLists<float>& lists, const std::uint32_t* places, const SplatTangent<float>* tangents,
               float* d_image) const;
  // sums[place] = what a pair adds to J_raster^T u.
  void Adjoint(const TileLists<float>& lists, const float* u, SplatTangent<float>* sums) const;

 private:
  CachePairs Pairs() const { return {pairs_.data(), first_entry_.data()}; }

  CacheFormat format_ = CacheFormat::kFull;
  Index num_entries_ = 0;
  DeviceBuffer<CachePair> pairs_;
  DeviceBuffer<Index> first_entry_;  // [pairs + 1]
  // One of the two, as the format has it.
  DeviceBuffer<CacheEntry<float>> full_;
  DeviceBuffer<CacheEntry<Half>> half_;
};

}  // namespace vesta::splat
