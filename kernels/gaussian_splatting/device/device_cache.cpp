// SPDX-License-Identifier: Apache-2.0
#include "kernels/gaussian_splatting/device/device_cache.h"

#include "kernels/core/device_sort.h"
#include "kernels/gaussian_splatting/device/device_cache_passes.h"

namespace vesta::splat {

void DeviceJacobianCache::Build(const TileLists<float>& lists, const std::uint32_t* places, Index pairs,
                                const float* image, CacheFormat format, DeviceBuffer<Index>& counts,
                                DeviceBuffer<unsigned char>& temporary) {
  DeviceJacobianCache made;
  made.format_ = format;
  made.pairs_.ResizeForOverwrite(pairs);
  made.first_entry_.ResizeForOverwrite(pairs + 1);
  // One more than there are pairs: the last running sum is the number of entries.
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
