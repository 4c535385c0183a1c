// SPDX-License-Identifier: Apache-2.0
// The cached Jacobian on a GPU: launches of cache_blocks.h.
#include "kernels/core/launch.cuh"
#include "kernels/gaussian_splatting/device/device_cache_passes.h"

namespace vesta::splat::device_passes {
namespace {

Index NumTiles(const TileLists<float>& lists) { return Index{lists.tiles_x} * lists.tiles_y; }

}  // namespace

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
