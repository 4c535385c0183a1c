// SPDX-License-Identifier: Apache-2.0
// One view of a model in the memory of a GPU: the same operators as SplatView, in float.
#pragma once

#include <algorithm>

#include "kernels/core/device_buffer.h"
#include "kernels/gaussian_splatting/cache/cache_blocks.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/projection/lens_motion.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/tiles/tile_pairs.h"

namespace vesta::splat {

// The Jacobian of a view's raster pass, kept in the memory of a GPU for the products of one linearisation.
//
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

// Memory that views share while they work one after the other. Contents mean nothing between calls but for splat_sums,
// which AddJT leaves as the cotangents by rank.
struct DeviceViewWorkspace {
  DeviceBuffer<std::uint32_t> keys, indices, other_keys, other_indices;  // by Gaussian
  DeviceBuffer<Splat<float>> unsorted;
  DeviceBuffer<Index> seen, counts;
  DeviceBuffer<std::uint32_t> tiles, entries, other_tiles, other_entries, rank_of_entry;  // by pair
  DeviceBuffer<SplatTangent<float>> pair_sums, splat_sums;
  DeviceBuffer<SplatGram<float>> pair_grams, splat_grams;
  DeviceBuffer<unsigned char> temporary;

  // As ViewWorkspace's.
  static double BuildBytes(const ViewCounts& view, double gaussians) {
    // Of CUB's sort, for each thing sorted: counters of the digits in each piece of some thousand. Estimated.
    constexpr double kSort = 0.25;
    return kSpareRoom * (gaussians * (4 * sizeof(std::uint32_t) + sizeof(Splat<float>)) +
                         5 * sizeof(std::uint32_t) * view.pairs) +
           sizeof(Index) * view.splats + kSort * std::max(gaussians, view.pairs);
  }
  static double ProductBytes(const ViewCounts& view) {
    return kSpareRoom * (view.splats + view.pairs) * sizeof(SplatTangent<float>);
  }
  // Entries are counted pair by pair, where else splats' tiles are.
  static double CacheBytes(const ViewCounts& view) { return sizeof(Index) * std::max(0.0, view.pairs - view.splats); }
  static double GramBytes(const ViewCounts& view) {
    return kSpareRoom * (view.splats + view.pairs) * sizeof(SplatGram<float>);
  }
};

// All pointers are to memory of the GPU. Build waits for the device twice, to learn how much memory the lists take; the
// operators neither wait nor, after their first call, allocate. The same bits every time: no sum is made by atomics.
class DeviceSplatView {
 public:
  using Cache = DeviceJacobianCache;

  // As SplatView's.
  static double Bytes(const ViewCounts& view, double gaussians) {
    return sizeof(Splat<float>) * view.splats + sizeof(std::int32_t) * gaussians +
           sizeof(Index) * (view.splats + view.tiles) + (2 + 1.0 / kFewTiles) * sizeof(std::uint32_t) * view.pairs;
  }

  // As SplatView::Build.
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
  // As SplatView::CacheJacobian. Waits once, for the number of entries; throws OutOfDeviceMemory.
  void CacheJacobian(const float* image, CacheFormat format, DeviceViewWorkspace& workspace);
  const DeviceJacobianCache& cache() const { return cache_; }
  void ApplyJ(const Model<float>& model, const float* dx, float* d_image, DeviceViewWorkspace& workspace) const;
  // d_image = J_raster tangents, by rank; and where tangents may be put for that: in workspace.splat_sums, or in
  // pair_sums, which no tangent pass takes.
  void ApplyRasterJ(const SplatTangent<float>* tangents, float* d_image) const;
  SplatTangent<float>* SplatTangents(DeviceBuffer<SplatTangent<float>>& room) const;
  // As SplatView's, one pass after the other.
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
  DeviceBuffer<std::uint32_t> ranks_, entries_;  // by pair; entries_: its place in the order of splats
  DeviceBuffer<std::uint32_t> wide_;             // splats of many tiles (wide_splats.h)
  DeviceJacobianCache cache_;
};

// The image of a view as a function of its camera's pose and lens: the products of camera_jacobian.h. Functions that
// return a cotangent wait for the device.
void ApplyPoseJ(const DeviceSplatView& view, const Model<float>& model, const PoseTangent& xi, float* d_image,
                DeviceViewWorkspace& workspace);
PoseTangent PoseCotangent(const DeviceSplatView& view, const Model<float>& model,
                          const SplatTangent<float>* cotangents);
void ApplyLensJ(const DeviceSplatView& view, const LensTangent& delta, float* d_image, DeviceViewWorkspace& workspace);
// As camera_jacobian.h has it.
void ApplyModelAndPoseJ(const DeviceSplatView& view, const Model<float>& model, const float* dx, const PoseTangent* xi,
                        float* d_image, DeviceViewWorkspace& workspace);
LensTangent LensCotangent(const DeviceSplatView& view, const SplatTangent<float>* cotangents);

}  // namespace vesta::splat
