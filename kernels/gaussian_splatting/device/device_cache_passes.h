// SPDX-License-Identifier: Apache-2.0
// The launches behind DeviceJacobianCache: what nvcc compiles. All pointers are to memory of the GPU; nothing waits. E
// is what the numbers of an entry are kept in: float or Half.
#pragma once

#include "kernels/gaussian_splatting/cache/cache_blocks.h"

namespace vesta::splat::device_passes {

using Index = std::int64_t;

// pairs[places[k]] of each pair k of the lists, and counts[e] of each place e.
void FindEntries(const TileLists<float>& lists, const std::uint32_t* places, Index size, CachePair* pairs,
                 Index* counts);
template <class E>
void FillEntries(const TileLists<float>& lists, const std::uint32_t* places, const CachePairs& cache,
                 const float* image, CacheEntry<E>* entries);
template <class E>
void CachedTangent(const TileLists<float>& lists, const std::uint32_t* places, const CachePairs& cache,
                   const CacheEntry<E>* entries, const SplatTangent<float>* tangents, float* d_image);
// sums: of each pair, at its place.
template <class E>
void CachedAdjoint(const TileLists<float>& lists, const CachePairs& cache, const CacheEntry<E>* entries, Index size,
                   const float* u, SplatTangent<float>* sums);

}  // namespace vesta::splat::device_passes
