// SPDX-License-Identifier: Apache-2.0
// Tile lists, raster passes and the cached Jacobian on a GPU: launches of tile_pairs.h, raster_blocks.h and
// cache_blocks.h.
#include "kernels/core/launch.cuh"
#include "kernels/gaussian_splatting/device/device_passes.h"
#include "kernels/gaussian_splatting/raster/raster_blocks.h"
#include "kernels/gaussian_splatting/tiles/wide_splats.h"

namespace vesta::splat::device_passes {

void CountVisibleSplats(const std::uint32_t* keys, Index count, Index* seen) {
  device::ForEach(count, CountVisible{keys, count, seen}, "counting splats");
}

void GatherSplats(const std::uint32_t* keys, const std::uint32_t* indices, Index count, const Splat<float>* unsorted,
                  Splat<float>* splats, std::int32_t* rank_of) {
  device::ForEach(count, GatherSorted<float>{keys, indices, count, unsorted, splats, rank_of}, "gathering splats");
}

void CountSplatTiles(const TileGrid& grid, const Splat<float>* splats, Index count, Index* counts) {
  device::ForEach(count, CountTiles<float>{grid, splats, counts}, "counting tiles");
}

void EmitSplatPairs(const TileGrid& grid, const Splat<float>* splats, Index count, const Index* splat_begin,
                    const PairArrays& pairs, DeviceBuffer<std::uint32_t>& wide) {
  device::ForEach(count, EmitPairs<float>{grid, splats, splat_begin, pairs}, "listing tiles");
  device::ForEach(count, MarkWideSplats{splat_begin, wide.data()}, "finding wide splats");
  device::Launch(EmitWidePairs<float>{{wide.data(), wide.size()}, grid, splats, splat_begin, pairs},
                 WideSlots::NumBlocks(wide.size()), "listing tiles of wide splats");
}

void PlaceSplatPairs(const std::uint32_t* tiles, const std::uint32_t* entries, const std::uint32_t* rank_of_entry,
                     Index pairs, int num_tiles, std::uint32_t* ranks, std::int64_t* tile_begin) {
  device::ForEach(pairs, PlacePairs{tiles, entries, rank_of_entry, pairs, num_tiles, ranks, tile_begin},
                  "placing pairs");
}

namespace {

Index NumTiles(const TileLists<float>& lists) { return Index{lists.tiles_x} * lists.tiles_y; }

template <class Record>
void SumRecords(const Index* splat_begin, Index splats, const DeviceBuffer<std::uint32_t>& wide, const Record* records,
                Record* sums) {
  constexpr int kN = sizeof(Record) / sizeof(float);
  const auto* values = reinterpret_cast<const float*>(records);
  auto* totals = reinterpret_cast<float*>(sums);
  device::ForEach(splats * kN, SumEntries<float, kN>{splat_begin, values, totals}, "sums by splat");
  device::Launch(SumWideBlock<float, kN>{{wide.data(), wide.size()}, splat_begin, values, totals},
                 WideSlots::NumBlocks(wide.size()), "sums of wide splats");
}

}  // namespace

void Forward(const TileLists<float>& lists, float* image) {
  device::Launch(ForwardBlock<float>{lists, image}, NumTiles(lists), "forward pass");
}

void Tangent(const TileLists<float>& lists, const SplatTangent<float>* tangents, float* d_image) {
  device::Launch(TangentBlock<float>{lists, tangents, d_image}, NumTiles(lists), "tangent pass");
}

void Adjoint(const TileLists<float>& lists, const std::uint32_t* entries, const float* image, const float* u,
             SplatTangent<float>* sums) {
  device::Launch(AdjointBlock<float>{lists, entries, image, u, sums}, NumTiles(lists), "adjoint pass");
}

void Gram(const TileLists<float>& lists, const std::uint32_t* entries, const float* image, const float* omega,
          SplatGram<float>* sums) {
  device::Launch(GramBlock<float>{lists, entries, image, omega, sums}, NumTiles(lists), "Gram pass");
}

void SumBySplat(const Index* splat_begin, Index splats, const DeviceBuffer<std::uint32_t>& wide,
                const SplatTangent<float>* records, SplatTangent<float>* sums) {
  SumRecords(splat_begin, splats, wide, records, sums);
}

void SumBySplat(const Index* splat_begin, Index splats, const DeviceBuffer<std::uint32_t>& wide,
                const SplatGram<float>* records, SplatGram<float>* sums) {
  SumRecords(splat_begin, splats, wide, records, sums);
}

void FindEntries(const TileLists<float>& lists, const std::uint32_t* places, Index size, CachePair* pairs,
                 Index* counts) {
  device::Launch(MaskBlock<float>{lists, places, pairs}, NumTiles(lists), "masks of entries");
  device::ForEach(size, CountEntries{pairs, counts}, "counting entries");
}

template <class E>
void FillEntries(const TileLists<float>& lists, const std::uint32_t* places, const CachePairs& cache,
                 const float* image, CacheEntry<E>* entries) {
  device::Launch(FillBlock<float, E>{lists, places, cache, image, entries}, NumTiles(lists), "filling entries");
}

template <class E>
void CachedTangent(const TileLists<float>& lists, const std::uint32_t* places, const CachePairs& cache,
                   const CacheEntry<E>* entries, const SplatTangent<float>* tangents, float* d_image) {
  device::Launch(CachedTangentBlock<float, E>{lists, places, cache, entries, tangents, d_image}, NumTiles(lists),
                 "cached tangent");
}

template <class E>
void CachedAdjoint(const TileLists<float>& lists, const CachePairs& cache, const CacheEntry<E>* entries, Index size,
                   const float* u, SplatTangent<float>* sums) {
  using Kernel = CachedAdjointBlock<float, E>;
  device::Launch(Kernel{lists, cache, entries, size, u, sums}, Kernel::NumBlocks(size), "cached adjoint");
}

#define VESTA_INSTANTIATE(E)                                                                                          \
  template void FillEntries(const TileLists<float>&, const std::uint32_t*, const CachePairs&, const float*,           \
                            CacheEntry<E>*);                                                                          \
  template void CachedTangent(const TileLists<float>&, const std::uint32_t*, const CachePairs&, const CacheEntry<E>*, \
                              const SplatTangent<float>*, float*);                                                    \
  template void CachedAdjoint(const TileLists<float>&, const CachePairs&, const CacheEntry<E>*, Index, const float*,  \
                              SplatTangent<float>*);
VESTA_INSTANTIATE(float)
VESTA_INSTANTIATE(Half)
#undef VESTA_INSTANTIATE

}  // namespace vesta::splat::device_passes
