// SPDX-License-Identifier: Apache-2.0
#include "kernels/gaussian_splatting/device/device_splat_view.h"

#include <algorithm>

#include "kernels/core/check.h"
#include "kernels/core/device_sort.h"
#include "kernels/core/profile.h"
#include "kernels/gaussian_splatting/device/device_passes.h"
#include "kernels/gaussian_splatting/tiles/wide_splats.h"

namespace vesta::splat {
namespace {

// With spare capacity, so that the next view seldom needs a reallocation.
template <class T>
void EnsureSize(DeviceBuffer<T>& buffer, Index size) {
  if (buffer.size() < size) buffer.ResizeForOverwrite(size + size / 8);
}

Index ReadBack(const Index* on_device) {
  Index value = 0;
  device::CopyToHost(&value, on_device, sizeof(value));
  return value;
}

}  // namespace

void DeviceSplatView::Build(const Model<float>& model, const PosedCamera& view, const double background[3],
                            DeviceViewWorkspace& workspace) {
  camera_ = view;
  for (int c = 0; c < 3; ++c) background_[c] = static_cast<float>(background[c]);
  const Index count = model.count;
  for (auto* buffer : {&workspace.keys, &workspace.indices, &workspace.other_keys, &workspace.other_indices}) {
    EnsureSize(*buffer, count);
  }
  EnsureSize(workspace.unsorted, count);
  ScopedPhase phase("projection");
  device_passes::Project(model, view, workspace.keys.data(), workspace.indices.data(), workspace.unsorted.data());
  phase.Next("sort");
  constexpr int kDepthBits = 32;
  device::SortPairs(workspace.keys, workspace.indices, workspace.other_keys, workspace.other_indices, count, kDepthBits,
                    workspace.temporary);
  workspace.seen.Resize(1);
  device_passes::CountVisibleSplats(workspace.keys.data(), count, workspace.seen.data());
  const Index seen = ReadBack(workspace.seen.data());

  splats_.ResizeForOverwrite(seen);
  rank_of_.ResizeForOverwrite(count);
  device_passes::GatherSplats(workspace.keys.data(), workspace.indices.data(), count, workspace.unsorted.data(),
                              splats_.data(), rank_of_.data());
  cache_.Clear();

  const TileGrid grid(camera_.width, camera_.height);
  // One more than splats: the last running sum is the number of pairs.
  workspace.counts.Resize(seen + 1);
  splat_begin_.ResizeForOverwrite(seen + 1);
  device_passes::CountSplatTiles(grid, splats_.data(), seen, workspace.counts.data());
  device::RunningSum(workspace.counts.data(), splat_begin_.data(), seen + 1, workspace.temporary);
  const Index pairs = ReadBack(splat_begin_.data() + seen);
  VESTA_CHECK(pairs < Index{0xffffffff}, "the splats of one view cover {} tiles in total; the limit is 2^32 - 2",
              pairs);

  for (auto* buffer : {&workspace.tiles, &workspace.entries, &workspace.other_tiles, &workspace.other_entries,
                       &workspace.rank_of_entry}) {
    EnsureSize(*buffer, pairs);
  }
  wide_.Resize(NumWideSlots(pairs));
  device_passes::EmitSplatPairs(grid, splats_.data(), seen, splat_begin_.data(),
                                {workspace.tiles.data(), workspace.rank_of_entry.data(), workspace.entries.data()},
                                wide_);
  device::SortPairs(workspace.tiles, workspace.entries, workspace.other_tiles, workspace.other_entries, pairs,
                    grid.key_bits(), workspace.temporary);
  ranks_.ResizeForOverwrite(pairs);
  tile_begin_.Resize(grid.num_tiles() + 1);
  device_passes::PlaceSplatPairs(workspace.tiles.data(), workspace.entries.data(), workspace.rank_of_entry.data(),
                                 pairs, grid.num_tiles(), ranks_.data(), tile_begin_.data());
  entries_.CopyFrom(Span<const std::uint32_t, Device>(workspace.entries.data(), pairs));
}

TileLists<float> DeviceSplatView::Lists() const {
  const TileGrid grid(camera_.width, camera_.height);
  return {splats_.data(), tile_begin_.data(), ranks_.data(), grid.width,
          grid.height,    grid.tiles_x,       grid.tiles_y,  {background_[0], background_[1], background_[2]}};
}

void DeviceSplatView::CacheJacobian(const float* image, CacheFormat format, DeviceViewWorkspace& workspace) {
  cache_.Build(Lists(), entries_.data(), num_pairs(), image, format, workspace.counts, workspace.temporary);
}

void DeviceSplatView::Render(float* image) const {
  const ScopedPhase phase("raster forward");
  device_passes::Forward(Lists(), image);
}

void DeviceSplatView::ApplyJ(const Model<float>& model, const float* dx, float* d_image,
                             DeviceViewWorkspace& workspace) const {
  {
    const ScopedPhase phase("projection tangent");
    device_passes::ProjectTangent(model, camera_, rank_of_.data(), dx, SplatTangents(workspace.splat_sums));
  }
  ApplyRasterJ(workspace.splat_sums.data(), d_image);
}

void DeviceSplatView::ApplyRasterJ(const SplatTangent<float>* tangents, float* d_image) const {
  const ScopedPhase phase("raster tangent");
  if (!cache_.empty()) return cache_.Tangent(Lists(), entries_.data(), tangents, d_image);
  device_passes::Tangent(Lists(), tangents, d_image);
}

SplatTangent<float>* DeviceSplatView::SplatTangents(DeviceBuffer<SplatTangent<float>>& buffer) const {
  EnsureSize(buffer, num_splats());
  return buffer.data();
}

void DeviceSplatView::AddJT(const Model<float>& model, const float* image, const float* u, float* g,
                            DeviceViewWorkspace& workspace) const {
  EnsureSize(workspace.pair_sums, num_pairs());
  EnsureSize(workspace.splat_sums, num_splats());
  ScopedPhase phase("raster backward");
  if (cache_.empty()) {
    device_passes::Adjoint(Lists(), entries_.data(), image, u, workspace.pair_sums.data());
  } else {
    cache_.Adjoint(Lists(), u, workspace.pair_sums.data());
  }
  device_passes::SumBySplat(splat_begin_.data(), num_splats(), wide_, workspace.pair_sums.data(),
                            workspace.splat_sums.data());
  phase.Next("projection backward");
  device_passes::ProjectAdjoint(model, camera_, rank_of_.data(), workspace.splat_sums.data(), g);
}

void DeviceSplatView::AddGram(const Model<float>& model, const float* image, const float* omega, float* blocks,
                              float* sh_diagonal, DeviceViewWorkspace& workspace) const {
  const ScopedPhase phase("Gram blocks");
  EnsureSize(workspace.pair_grams, num_pairs());
  EnsureSize(workspace.splat_grams, num_splats());
  device_passes::Gram(Lists(), entries_.data(), image, omega, workspace.pair_grams.data());
  device_passes::SumBySplat(splat_begin_.data(), num_splats(), wide_, workspace.pair_grams.data(),
                            workspace.splat_grams.data());
  device_passes::ProjectGram(model, camera_, rank_of_.data(), workspace.splat_grams.data(), blocks, sh_diagonal);
}

void ApplyPoseJ(const DeviceSplatView& view, const Model<float>& model, const PoseTangent& xi, float* d_image,
                DeviceViewWorkspace& workspace) {
  device_passes::PoseTangents(model, view.camera(), view.rank_of().data(), xi,
                              view.SplatTangents(workspace.splat_sums));
  view.ApplyRasterJ(workspace.splat_sums.data(), d_image);
}

PoseTangent PoseCotangent(const DeviceSplatView& view, const Model<float>& model,
                          const SplatTangent<float>* cotangents) {
  return device_passes::PoseCotangent(model, view.camera(), view.rank_of().data(), cotangents);
}

void ApplyLensJ(const DeviceSplatView& view, const LensTangent& delta, float* d_image, DeviceViewWorkspace& workspace) {
  device_passes::LensTangents(view.splats().data(), view.num_splats(), view.camera(), delta,
                              view.SplatTangents(workspace.splat_sums));
  view.ApplyRasterJ(workspace.splat_sums.data(), d_image);
}

void ApplyModelAndPoseJ(const DeviceSplatView& view, const Model<float>& model, const float* dx, const PoseTangent* xi,
                        float* d_image, DeviceViewWorkspace& workspace) {
  const PosedCamera& camera = view.camera();
  SplatTangent<float>* const sum = view.SplatTangents(workspace.splat_sums);
  device_passes::ProjectTangent(model, camera, view.rank_of().data(), dx, sum);
  if (xi) {
    SplatTangent<float>* const moved = view.SplatTangents(workspace.pair_sums);
    device_passes::PoseTangents(model, camera, view.rank_of().data(), *xi, moved);
    device_passes::AddTangents(moved, view.num_splats(), sum);
  }
  view.ApplyRasterJ(sum, d_image);
}

LensTangent LensCotangent(const DeviceSplatView& view, const SplatTangent<float>* cotangents) {
  return device_passes::LensCotangent(view.splats().data(), view.num_splats(), view.camera(), cotangents);
}

void DeviceJacobianCache::Build(const TileLists<float>& lists, const std::uint32_t* places, Index pairs,
                                const float* image, CacheFormat format, DeviceBuffer<Index>& counts,
                                DeviceBuffer<unsigned char>& temporary) {
  DeviceJacobianCache made;
  made.format_ = format;
  made.pairs_.ResizeForOverwrite(pairs);
  made.first_entry_.ResizeForOverwrite(pairs + 1);
  // One more than pairs: the last running sum is the number of entries.
  counts.Resize(pairs + 1);
  device_passes::FindEntries(lists, places, pairs, made.pairs_.data(), counts.data());
  device::RunningSum(counts.data(), made.first_entry_.data(), pairs + 1, temporary);
  device::CopyToHost(&made.num_entries_, made.first_entry_.data() + pairs, sizeof(made.num_entries_));
  if (format == CacheFormat::kFull) {
    made.full_.ResizeForOverwrite(made.num_entries_);
    device_passes::FillEntries(lists, places, made.Pairs(), image, made.full_.data());
  } else {
    made.half_.ResizeForOverwrite(made.num_entries_);
    device_passes::FillEntries(lists, places, made.Pairs(), image, made.half_.data());
  }
  *this = std::move(made);
}

void DeviceJacobianCache::Tangent(const TileLists<float>& lists, const std::uint32_t* places,
                                  const SplatTangent<float>* tangents, float* d_image) const {
  if (format_ == CacheFormat::kFull) {
    device_passes::CachedTangent(lists, places, Pairs(), full_.data(), tangents, d_image);
  } else {
    device_passes::CachedTangent(lists, places, Pairs(), half_.data(), tangents, d_image);
  }
}

void DeviceJacobianCache::Adjoint(const TileLists<float>& lists, const float* u, SplatTangent<float>* sums) const {
  if (format_ == CacheFormat::kFull) {
    device_passes::CachedAdjoint(lists, Pairs(), full_.data(), pairs_.size(), u, sums);
  } else {
    device_passes::CachedAdjoint(lists, Pairs(), half_.data(), pairs_.size(), u, sums);
  }
}

}  // namespace vesta::splat
