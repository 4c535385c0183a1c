// SPDX-License-Identifier: Apache-2.0
// The GPU functions that DeviceSplatView calls, compiled by nvcc. Each launches one or a few kernels. All pointers are
// to GPU memory. PoseCotangent and LensCotangent return a sum to the host and therefore wait; all others return at
// once.
#pragma once

#include "kernels/core/device_buffer.h"
#include "kernels/gaussian_splatting/cache/cache_blocks.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/projection/lens_motion.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/tiles/tile_pairs.h"

namespace vesta::splat::device_passes {

using Index = std::int64_t;

// The functions of ProjectKernels, for all Gaussians. rank_of[i]: index of Gaussian i in depth order, or -1 if not
// visible. Project also sets indices[i] = i, for the sort by depth.
void Project(const Model<float>& model, const PosedCamera& view, std::uint32_t* keys, std::uint32_t* indices,
             Splat<float>* splats);
void ProjectTangent(const Model<float>& model, const PosedCamera& view, const std::int32_t* rank_of, const float* dx,
                    SplatTangent<float>* tangents);
void ProjectAdjoint(const Model<float>& model, const PosedCamera& view, const std::int32_t* rank_of,
                    const SplatTangent<float>* cotangents, float* g);
void ProjectGram(const Model<float>& model, const PosedCamera& view, const std::int32_t* rank_of,
                 const SplatGram<float>* grams, float* blocks, float* sh_diagonal);

// Derivatives with respect to the camera. The Pose functions apply CameraKernels to all Gaussians. The Lens functions
// apply the LensRows of lens_motion.h to all splats.
void PoseTangents(const Model<float>& model, const PosedCamera& view, const std::int32_t* rank_of,
                  const PoseTangent& xi, SplatTangent<float>* tangents);
PoseTangent PoseCotangent(const Model<float>& model, const PosedCamera& view, const std::int32_t* rank_of,
                          const SplatTangent<float>* cotangents);
void LensTangents(const Splat<float>* splats, Index count, const PosedCamera& camera, const LensTangent& delta,
                  SplatTangent<float>* tangents);
// sum += tangents.
void AddTangents(const SplatTangent<float>* tangents, Index count, SplatTangent<float>* sum);
LensTangent LensCotangent(const Splat<float>* splats, Index count, const PosedCamera& camera,
                          const SplatTangent<float>* cotangents);

// The steps of tile_pairs.h, in their order.
void CountVisibleSplats(const std::uint32_t* keys, Index count, Index* seen);
void GatherSplats(const std::uint32_t* keys, const std::uint32_t* indices, Index count, const Splat<float>* unsorted,
                  Splat<float>* splats, std::int32_t* rank_of);
void CountSplatTiles(const TileGrid& grid, const Splat<float>* splats, Index count, Index* counts);
// wide: receives the splats that cover many tiles (wide_splats.h). It has NumWideSlots(pairs) entries, all 0 on entry.
void EmitSplatPairs(const TileGrid& grid, const Splat<float>* splats, Index count, const Index* splat_begin,
                    const PairArrays& pairs, DeviceBuffer<std::uint32_t>& wide);
void PlaceSplatPairs(const std::uint32_t* tiles, const std::uint32_t* entries, const std::uint32_t* rank_of_entry,
                     Index pairs, int num_tiles, std::uint32_t* ranks, std::int64_t* tile_begin);

// The block kernels of raster_blocks.h, for all tiles. Adjoint and Gram write one record per (splat, tile) pair: its
// sums over the pixels of the tile. The record of pair k of the lists is sums[entries[k]]. In this order, the records
// of a splat are adjacent. SumBySplat then adds them.
void Forward(const TileLists<float>& lists, float* image);
void Tangent(const TileLists<float>& lists, const SplatTangent<float>* tangents, float* d_image);
void Adjoint(const TileLists<float>& lists, const std::uint32_t* entries, const float* image, const float* u,
             SplatTangent<float>* sums);
void Gram(const TileLists<float>& lists, const std::uint32_t* entries, const float* image, const float* omega,
          SplatGram<float>* sums);
// wide: from EmitSplatPairs.
void SumBySplat(const Index* splat_begin, Index splats, const DeviceBuffer<std::uint32_t>& wide,
                const SplatTangent<float>* records, SplatTangent<float>* sums);
void SumBySplat(const Index* splat_begin, Index splats, const DeviceBuffer<std::uint32_t>& wide,
                const SplatGram<float>* records, SplatGram<float>* sums);

// The GPU functions of DeviceJacobianCache. E is the number format of an entry: float or Half.
//
// The cache orders its (splat, tile) pairs by splat; pair k of the tile lists is pair places[k] of the cache.
// FindEntries computes pairs[e], with its mask, and counts[e], its number of entries. size: number of pairs.
void FindEntries(const TileLists<float>& lists, const std::uint32_t* places, Index size, CachePair* pairs,
                 Index* counts);
template <class E>
void FillEntries(const TileLists<float>& lists, const std::uint32_t* places, const CachePairs& cache,
                 const float* image, CacheEntry<E>* entries);
template <class E>
void CachedTangent(const TileLists<float>& lists, const std::uint32_t* places, const CachePairs& cache,
                   const CacheEntry<E>* entries, const SplatTangent<float>* tangents, float* d_image);
// sums[e]: the sums of pair e, for SumBySplat.
template <class E>
void CachedAdjoint(const TileLists<float>& lists, const CachePairs& cache, const CacheEntry<E>* entries, Index size,
                   const float* u, SplatTangent<float>* sums);

}  // namespace vesta::splat::device_passes
