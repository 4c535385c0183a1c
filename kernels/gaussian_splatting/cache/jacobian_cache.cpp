// SPDX-License-Identifier: Apache-2.0
#include "kernels/gaussian_splatting/cache/jacobian_cache.h"

#include <bit>
#include <numeric>

#include "kernels/core/parallel.h"

namespace vesta::splat {
namespace {

constexpr Index kTileGrain = 4, kSplatGrain = 128;
// Packed vectors are read in full width.
constexpr Index kReadableBeyond = 64;

Index EntriesOf(const TileMask& mask) {
  Index count = 0;
  for (const std::uint16_t row : mask.rows) count += std::popcount(row);
  return count;
}

template <class S>
Index BytesOfEntry(CacheFormat format) {
  return kEntryValues * (format == CacheFormat::kFull ? static_cast<Index>(sizeof(S)) : Index{2});
}

}  // namespace

template <class S>
CacheLists JacobianCache<S>::Lists(const TileBins& bins) const {
  return {masks_.data(), first_entry_.data(), bins.splat_begin(), bins.pairs_of_splat(), bins.tiles_of_splat()};
}

template <class S>
Index JacobianCache<S>::NumBytes(Index num_entries, Index num_pairs, CacheFormat format) {
  return num_entries * BytesOfEntry<S>(format) + kReadableBeyond +
         num_pairs * static_cast<Index>(sizeof(TileMask) + sizeof(std::int64_t));
}

template <class S>
Index JacobianCache<S>::num_bytes() const {
  return entries_.size() + masks_.size() * static_cast<Index>(sizeof(TileMask) + sizeof(std::int64_t));
}

template <class S>
void JacobianCache<S>::Build(const TileLists<S>& lists, const TileBins& bins, const S* image, CacheFormat format) {
  kernels_ = &CacheKernelsFor<S>(isa_, format);
  const Index pairs = bins.num_pairs(), splats = bins.num_splats();
  masks_.ResizeForOverwrite(pairs);
  first_entry_.ResizeForOverwrite(pairs);
  ParallelFor(bins.num_tiles(), kTileGrain,
              [&](Index tile) { kernels_->masks(lists, static_cast<int>(tile), masks_.data()); });
  const CacheLists cache = Lists(bins);
  const auto for_pairs = [&](Index rank, const auto& visit) {
    for (Index e = cache.splat_begin[rank]; e < cache.splat_begin[rank + 1]; ++e) visit(cache.pairs_of_splat[e]);
  };
  HostBuffer<std::int64_t> first(splats + 1);
  ParallelFor(splats, kSplatGrain, [&](Index rank) {
    for_pairs(rank, [&](std::uint32_t pair) { first[rank + 1] += EntriesOf(masks_[pair]); });
  });
  std::partial_sum(first.begin(), first.end(), first.begin());
  num_entries_ = first[splats];
  ParallelFor(splats, kSplatGrain, [&](Index rank) {
    Index at = first[rank];
    for_pairs(rank, [&](std::uint32_t pair) {
      first_entry_[pair] = at;
      at += EntriesOf(masks_[pair]);
    });
  });
  entries_.ResizeForOverwrite(num_entries_ * BytesOfEntry<S>(format) + kReadableBeyond);
  std::fill_n(entries_.end() - kReadableBeyond, kReadableBeyond, std::byte{});
  ParallelFor(bins.num_tiles(), kTileGrain,
              [&](Index tile) { kernels_->fill(lists, cache, static_cast<int>(tile), image, entries_.data()); });
}

template <class S>
void JacobianCache<S>::Tangent(const TileLists<S>& lists, const TileBins& bins, const SplatTangent<S>* tangents,
                               S* d_image) const {
  const CacheLists cache = Lists(bins);
  ParallelFor(bins.num_tiles(), kTileGrain, [&](Index tile) {
    kernels_->tangent(lists, cache, entries_.data(), static_cast<int>(tile), tangents, d_image);
  });
}

template <class S>
void JacobianCache<S>::Adjoint(const TileLists<S>& lists, const TileBins& bins, const S* u, SplatTangent<S>* sums,
                               HostBuffer<S>& u_tiles) const {
  u_tiles.ResizeForOverwrite(Index{3} * kTileSize * kTileSize * bins.num_tiles());
  ParallelFor(bins.num_tiles(), 16 * kTileGrain,
              [&](Index tile) { kernels_->to_tiles(lists, static_cast<int>(tile), u, u_tiles.data()); });
  const CacheLists cache = Lists(bins);
  ParallelForChunks(bins.num_splats(), kSplatGrain, [&](Index begin, Index end) {
    kernels_->adjoint(lists, cache, entries_.data(), begin, end, u_tiles.data(), sums);
  });
}

template class JacobianCache<float>;
template class JacobianCache<double>;

}  // namespace vesta::splat
