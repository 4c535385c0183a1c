// SPDX-License-Identifier: Apache-2.0
// One view of a model on a GPU: the operators of SplatView, in float.
#pragma once

#include <algorithm>

#include "kernels/core/device_buffer.h"
#include "kernels/gaussian_splatting/cache/cache_blocks.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/projection/lens_motion.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/tiles/tile_pairs.h"

namespace vesta::splat {

// Cached Jacobian of a view's raster pass, for the products of one linearisation.
//
// Like JacobianCache, in float. An entry has 16 or 8 bytes of values. Each (splat, tile) pair has 64 bytes for its mask
// and position. A pair typically has 50 to 80 entries, so this is about one byte per entry. Results are bit-identical
// in every run. All pointers are to GPU memory; products neither wait nor allocate.
class DeviceJacobianCache {
 public:
  // Computes the Jacobian and discards a previous one. Tangent and Adjoint need the same lists and places. The cache
  // orders the (splat, tile) pairs by splat; pair k of the lists is pair places[k] of the cache. pairs: number of
  // pairs. image: rendered from the lists. counts, temporary: scratch memory. Waits once, for the number of entries. On
  // failure throws OutOfDeviceMemory and leaves the cache empty.
  void Build(const TileLists<float>& lists, const std::uint32_t* places, Index pairs, const float* image,
             CacheFormat format, DeviceBuffer<Index>& counts, DeviceBuffer<unsigned char>& temporary);
  void Clear() { *this = DeviceJacobianCache(); }
  bool empty() const { return first_entry_.empty(); }
  Index num_entries() const { return num_entries_; }
  Index num_bytes() const { return empty() ? 0 : NumBytes(num_entries_, pairs_.size(), format_); }
  // Memory of a cache with these numbers of entries and pairs.
  static constexpr Index NumBytes(Index entries, Index pairs, CacheFormat format) {
    const std::size_t entry = format == CacheFormat::kFull ? sizeof(CacheEntry<float>) : sizeof(CacheEntry<Half>);
    return entries * static_cast<Index>(entry) + pairs * static_cast<Index>(sizeof(CachePair)) +
           (pairs + 1) * static_cast<Index>(sizeof(Index));
  }

  // d_image = J_raster tangents, by rank.
  void Tangent(const TileLists<float>& lists, const std::uint32_t* places, const SplatTangent<float>* tangents,
               float* d_image) const;
  // sums[e] = contribution of pair e to J_raster^T u.
  void Adjoint(const TileLists<float>& lists, const float* u, SplatTangent<float>* sums) const;

 private:
  CachePairs Pairs() const { return {pairs_.data(), first_entry_.data()}; }

  CacheFormat format_ = CacheFormat::kFull;
  Index num_entries_ = 0;
  DeviceBuffer<CachePair> pairs_;
  DeviceBuffer<Index> first_entry_;  // [pairs + 1]
  // Only the buffer of format_ is used.
  DeviceBuffer<CacheEntry<float>> full_;
  DeviceBuffer<CacheEntry<Half>> half_;
};

// Scratch memory that several views may share, one after the other. Its contents are undefined between calls, except
// splat_sums. There AddJT stores the cotangent of each splat by rank, the splat's index in depth order.
struct DeviceViewWorkspace {
  DeviceBuffer<std::uint32_t> keys, indices, other_keys, other_indices;  // by Gaussian
  DeviceBuffer<Splat<float>> unsorted;
  DeviceBuffer<Index> seen, counts;
  DeviceBuffer<std::uint32_t> tiles, entries, other_tiles, other_entries, rank_of_entry;  // by pair
  DeviceBuffer<SplatTangent<float>> pair_sums, splat_sums;
  DeviceBuffer<SplatGram<float>> pair_grams, splat_grams;
  DeviceBuffer<unsigned char> temporary;

  // Bytes for the functions of ViewWorkspace (splat_view.h).
  static double BuildBytes(const ViewCounts& view, double gaussians) {
    // Estimate for CUB's sort: digit counters for each chunk of about a thousand items.
    constexpr double kSort = 0.25;
    return kSpareCapacity * (gaussians * (4 * sizeof(std::uint32_t) + sizeof(Splat<float>)) +
                             5 * sizeof(std::uint32_t) * view.pairs) +
           sizeof(Index) * view.splats + kSort * std::max(gaussians, view.pairs);
  }
  static double ProductBytes(const ViewCounts& view) {
    return kSpareCapacity * (view.splats + view.pairs) * sizeof(SplatTangent<float>);
  }
  // A cached Jacobian needs one element of `counts` per pair. Build needs only one per splat.
  static double CacheBytes(const ViewCounts& view) { return sizeof(Index) * std::max(0.0, view.pairs - view.splats); }
  static double GramBytes(const ViewCounts& view) {
    return kSpareCapacity * (view.splats + view.pairs) * sizeof(SplatGram<float>);
  }
};

// All pointers are to GPU memory. Build waits twice, for the sizes of the lists. The operators do not wait. They
// allocate only in their first call. Results are bit-identical in every run because no sum uses atomics.
class DeviceSplatView {
 public:
  using Cache = DeviceJacobianCache;

  // Bytes of a view without a cache.
  static double Bytes(const ViewCounts& view, double gaussians) {
    return sizeof(Splat<float>) * view.splats + sizeof(std::int32_t) * gaussians +
           sizeof(Index) * (view.splats + view.tiles) + (2 + 1.0 / kFewTiles) * sizeof(std::uint32_t) * view.pairs;
  }

  // See SplatView::Build.
  void Build(const Model<float>& model, const PosedCamera& view, const double background[3],
             DeviceViewWorkspace& workspace);

  const PosedCamera& camera() const { return camera_; }
  Index num_pixels() const { return Index{camera_.width} * camera_.height; }
  Index num_splats() const { return splats_.size(); }
  Index num_pairs() const { return ranks_.size(); }
  Span<const std::int32_t, Device> rank_of() const { return rank_of_; }
  Span<const Splat<float>, Device> splats() const { return splats_; }

  TileLists<float> Lists() const;
  void Render(float* image) const;
  // See SplatView::CacheJacobian. Waits once, for the number of entries. Throws OutOfDeviceMemory.
  void CacheJacobian(const float* image, CacheFormat format, DeviceViewWorkspace& workspace);
  const DeviceJacobianCache& cache() const { return cache_; }
  void ApplyJ(const Model<float>& model, const float* dx, float* d_image, DeviceViewWorkspace& workspace) const;
  // d_image = J_raster tangents. tangents: by rank.
  void ApplyRasterJ(const SplatTangent<float>* tangents, float* d_image) const;
  // Memory for one tangent per splat, in `buffer`. This is workspace.splat_sums or workspace.pair_sums, because tangent
  // passes do not use them otherwise.
  SplatTangent<float>* SplatTangents(DeviceBuffer<SplatTangent<float>>& buffer) const;
  // Render and ApplyJ, one after the other (SplatView runs both passes together).
  void RenderAndApplyJ(const Model<float>& model, const float* dx, float* image, float* d_image,
                       DeviceViewWorkspace& workspace) const {
    Render(image);
    ApplyJ(model, dx, d_image, workspace);
  }
  void AddJT(const Model<float>& model, const float* image, const float* u, float* g,
             DeviceViewWorkspace& workspace) const;
  void AddGram(const Model<float>& model, const float* image, const float* omega, float* blocks, float* sh_diagonal,
               DeviceViewWorkspace& workspace) const;

 private:
  PosedCamera camera_{};
  float background_[3]{};
  DeviceBuffer<Splat<float>> splats_;
  DeviceBuffer<std::int32_t> rank_of_;
  DeviceBuffer<Index> splat_begin_, tile_begin_;
  // One element per (splat, tile) pair. entries_: index of the pair in the order by splat.
  DeviceBuffer<std::uint32_t> ranks_, entries_;
  DeviceBuffer<std::uint32_t> wide_;  // splats with many tiles (wide_splats.h)
  DeviceJacobianCache cache_;
};

// The image of a view as a function of its camera's pose and lens: the products of camera_jacobian.h. Functions that
// return a cotangent wait.
void ApplyPoseJ(const DeviceSplatView& view, const Model<float>& model, const PoseTangent& xi, float* d_image,
                DeviceViewWorkspace& workspace);
PoseTangent PoseCotangent(const DeviceSplatView& view, const Model<float>& model,
                          const SplatTangent<float>* cotangents);
void ApplyLensJ(const DeviceSplatView& view, const LensTangent& delta, float* d_image, DeviceViewWorkspace& workspace);
// See camera_jacobian.h.
void ApplyModelAndPoseJ(const DeviceSplatView& view, const Model<float>& model, const float* dx, const PoseTangent* xi,
                        float* d_image, DeviceViewWorkspace& workspace);
LensTangent LensCotangent(const DeviceSplatView& view, const SplatTangent<float>* cotangents);

}  // namespace vesta::splat
