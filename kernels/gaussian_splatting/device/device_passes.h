// SPDX-License-Identifier: Apache-2.0 Kernel launches of DeviceSplatView, compiled by nvcc. All pointers are to GPU
// memory. Only functions that return a sum wait.
#pragma once

#include "kernels/core/device_buffer.h"
#include "kernels/gaussian_splatting/cache/cache_blocks.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/projection/lens_motion.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/tiles/tile_pairs.h"

namespace vesta::splat::device_passes {

using Index = std::int64_t;

// ProjectKernels for all Gaussians of the model; indices[i] = i.
void Project(const Model<float>& model, const PosedCamera& view, std::uint32_t* keys, std::uint32_t* indices,
             Splat<float>* splats);
void ProjectTangent(const Model<float>& model, const PosedCamera& view, const std::int32_t* rank_of, const float* dx,
                    SplatTangent<float>* tangents);
void ProjectAdjoint(const Model<float>& model, const PosedCamera& view, const std::int32_t* rank_of,
                    const SplatTangent<float>* cotangents, float* g);
void ProjectGram(const Model<float>& model, const PosedCamera& view, const std::int32_t* rank_of,
                 const SplatGram<float>* grams, float* blocks, float* sh_diagonal);

// CameraKernels for all Gaussians of the model, and the functions of lens_motion.h for each splat.
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

// The steps of tile_pairs.h.
void CountSeenSplats(const std::uint32_t* keys, Index count, Index* seen);
void GatherSplats(const std::uint32_t* keys, const std::uint32_t* indices, Index count, const Splat<float>* unsorted,
                  Splat<float>* splats, std::int32_t* rank_of);
void CountSplatTiles(const TileGrid& grid, const Splat<float>* splats, Index count, Index* counts);
// wide: NumWideSlots slots, 0 before.
void EmitSplatPairs(const TileGrid& grid, const Splat<float>* splats, Index count, const Index* splat_begin,
                    const PairArrays& pairs, DeviceBuffer<std::uint32_t>& wide);
void PlaceSplatPairs(const std::uint32_t* tiles, const std::uint32_t* entries, const std::uint32_t* rank_of_entry,
                     Index pairs, int num_tiles, std::uint32_t* ranks, std::int64_t* tile_begin);

// The block kernels of raster_blocks.h over all tiles, and the sums of their records per splat.
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

// Kernel launches of DeviceJacobianCache. E is the number format of an entry: float or Half.
//
// Computes pairs[places[k]] for each pair k of the lists, and counts[e] for each place e.
void FindEntries(const TileLists<float>& lists, const std::uint32_t* places, Index size, CachePair* pairs,
                 Index* counts);
template <class E>
void FillEntries(const TileLists<float>& lists, const std::uint32_t* places, const CachePairs& cache,
                 const float* image, CacheEntry<E>* entries);
template <class E>
void CachedTangent(const TileLists<float>& lists, const std::uint32_t* places, const CachePairs& cache,
                   const CacheEntry<E>* entries, const SplatTangent<float>* tangents, float* d_image);
// sums: one per pair, at its place.
template <class E>
void CachedAdjoint(const TileLists<float>& lists, const CachePairs& cache, const CacheEntry<E>* entries, Index size,
                   const float* u, SplatTangent<float>* sums);

}  // namespace vesta::splat::device_passes
