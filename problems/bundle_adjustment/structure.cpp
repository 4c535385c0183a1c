// SPDX-License-Identifier: Apache-2.0
#include "problems/bundle_adjustment/structure.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::bundle {
namespace {

// Offsets for a counting sort: items with key k get the places first[k]..first[k + 1] - 1.
template <class KeyOf>
HostBuffer<Index> FirstPlaces(Index keys, Index count, const KeyOf& key_of) {
  HostBuffer<Index> first(keys + 1);
  for (Index i = 0; i < count; ++i) ++first[key_of(i) + 1];
  for (Index k = 0; k < keys; ++k) first[k + 1] += first[k];
  return first;
}

// Indices of the items sorted by key; items with equal keys keep their order.
template <class KeyOf>
std::vector<std::int32_t> SortByKey(const HostBuffer<Index>& first, Index count, const KeyOf& key_of) {
  std::vector<Index> next(first.begin(), first.end() - 1);
  std::vector<std::int32_t> sorted(static_cast<std::size_t>(count));
  for (Index i = 0; i < count; ++i) {
    sorted[static_cast<std::size_t>(next[static_cast<std::size_t>(key_of(i))]++)] = static_cast<std::int32_t>(i);
  }
  return sorted;
}

}  // namespace

Structure::Structure(const BundleData& data) : num_cameras_(data.num_cameras), num_points_(data.num_points) {
  const auto& observations = data.observations;
  const Index count = static_cast<Index>(observations.size());
  if (num_cameras_ < 0 || num_points_ < 0 || static_cast<Index>(data.x.size()) != num_parameters()) {
    Fail(kBadArgument, "bundle adjustment: {} cameras and {} points do not match {} parameters", num_cameras_,
         num_points_, data.x.size());
  }
  if (count > std::numeric_limits<std::int32_t>::max())
    Fail(kUnsupported, "bundle adjustment: {} observations are more than the limit of 2^31 - 1", count);
  for (const Observation& o : observations) {
    if (o.camera < 0 || o.camera >= num_cameras_ || o.point < 0 || o.point >= num_points_) {
      Fail(kBadArgument, "an observation of point {} by camera {} is out of range: there are {} points and {} cameras",
           o.point, o.camera, num_points_, num_cameras_);
    }
  }
  // Sorting by camera, then stably by track gives track order. Sorting that by camera gives camera order, tracks
  // ascending.
  const auto at = [&](Index i) -> const Observation& { return observations[static_cast<std::size_t>(i)]; };
  camera_first_ = FirstPlaces(num_cameras_, count, [&](Index i) { return at(i).camera; });
  const auto by_camera = SortByKey(camera_first_, count, [&](Index i) { return at(i).camera; });
  const auto item = [&](Index i) -> const Observation& { return at(by_camera[static_cast<std::size_t>(i)]); };
  // Tracks are in the order of their first cameras; points without observations come last.
  std::vector<std::int32_t> track_of(static_cast<std::size_t>(num_points_), -1);
  track_point_.Resize(num_points_);
  std::int32_t tracks = 0;
  const auto append = [&](std::int32_t point) {
    std::int32_t& track = track_of[static_cast<std::size_t>(point)];
    if (track >= 0) return;
    track_point_[tracks] = point;
    track = tracks++;
  };
  for (Index i = 0; i < count; ++i) append(item(i).point);
  for (Index p = 0; p < num_points_; ++p) append(static_cast<std::int32_t>(p));
  const auto track = [&](Index i) { return track_of[static_cast<std::size_t>(item(i).point)]; };
  track_first_ = FirstPlaces(num_points_, count, track);
  const auto by_track = SortByKey(track_first_, count, track);
  camera_.Resize(count);
  for (Index i = 0; i < count; ++i) camera_[i] = item(by_track[static_cast<std::size_t>(i)]).camera;
  const auto again = SortByKey(camera_first_, count, [&](Index i) { return camera_[i]; });
  for (HostBuffer<std::int32_t>* buffer : {&position_, &point_, &track_}) buffer->Resize(count);
  observed_.Resize(2 * count);
  for (Index i = 0; i < count; ++i) {
    position_[i] = again[static_cast<std::size_t>(i)];
    const Observation& o = item(by_track[static_cast<std::size_t>(position_[i])]);
    point_[i] = o.point;
    track_[i] = track_of[static_cast<std::size_t>(o.point)];
    std::copy_n(o.pixel, 2, observed_.data() + 2 * i);
  }

  for (Index k = 0; k < num_points_; ++k) {
    const Index length = track_first_[k + 1] - track_first_[k];
    longest_track_ = std::max(longest_track_, length);
    num_pairs_ += length * (length + 1) / 2;
  }
  // Each chunk clears and adds its own sums for all cameras, so a chunk needs many more observations than cameras.
  const Index chunks = std::clamp<Index>(count / std::max<Index>(2048, 8 * num_cameras_), 1, 32);
  chunk_first_.push_back(0);
  for (Index chunk = 1; chunk <= chunks; ++chunk) {
    const Index target = count / chunks * chunk;
    const Index* found = std::lower_bound(track_first_.begin(), track_first_.end() - 1, target);
    chunk_first_.push_back(chunk == chunks ? num_points_ : std::min<Index>(found - track_first_.begin(), num_points_));
  }
  for (Index i = 0; i < num_cameras_; ++i) {
    first_slice_.push_back(static_cast<Index>(slice_begin_.size()));
    for (Index begin = camera_first_[i]; begin < camera_first_[i + 1]; begin += kSliceSize) {
      slice_camera_.push_back(i);
      slice_begin_.push_back(begin);
    }
  }
  first_slice_.push_back(static_cast<Index>(slice_begin_.size()));
}

CameraSlice Structure::Range(Index begin, Index end) const {
  return {end - begin, point_.data() + begin, track_.data() + begin, position_.data() + begin,
          observed_.data() + 2 * begin};
}

CameraSlice Structure::slice(Index slice) const {
  const Index begin = slice_begin_[static_cast<std::size_t>(slice)];
  return Range(begin, std::min(begin + kSliceSize, camera_first_[slice_camera(slice) + 1]));
}

CameraSlice Structure::camera_observations(Index camera) const {
  return Range(camera_first_[camera], camera_first_[camera + 1]);
}

template <class Body>
void Structure::ForEachPair(Index camera, bool diagonal_only, const Body& body) const {
  const CameraSlice own = camera_observations(camera);
  for (Index i = 0; i < own.count; ++i) {
    // Cameras ascend along a track; a camera may observe the point more than once.
    const Index begin = track_first_[own.track[i]], end = track_first_[own.track[i] + 1];
    Index o = own.position[i];
    while (o > begin && camera_[o - 1] == camera) --o;
    for (; o < end && (!diagonal_only || camera_[o] == camera); ++o) body(i, o);
  }
}

void Structure::NumberBlocks(Index camera, const ReducedPattern& pattern,
                             std::vector<std::int32_t>& block_of_camera) const {
  block_of_camera.resize(static_cast<std::size_t>(num_cameras_));
  const Index row = pattern.row_first[camera];
  for (Index k = row; k < pattern.row_first[camera + 1]; ++k) {
    block_of_camera[static_cast<std::size_t>(pattern.column[k])] = static_cast<std::int32_t>(k - row);
  }
}

void Structure::ListPairs(Index camera, const ReducedPattern& pattern, std::vector<Index>& first,
                          std::vector<ObservationPair>& pairs) const {
  std::vector<std::int32_t> block_of_camera;
  NumberBlocks(camera, pattern, block_of_camera);
  const Index row = pattern.row_first[camera], end = pattern.row_first[camera + 1];
  first.resize(static_cast<std::size_t>(end - row) + 1);
  for (Index k = row; k <= end; ++k) {
    first[static_cast<std::size_t>(k - row)] = pattern.pair_first[k] - pattern.pair_first[row];
  }
  std::vector<Index> next(first.begin(), first.end() - 1);
  pairs.resize(static_cast<std::size_t>(first.back()));
  ForEachPair(camera, pattern.diagonal_only, [&](Index i, Index o) {
    const auto block = static_cast<std::size_t>(block_of_camera[static_cast<std::size_t>(camera_[o])]);
    pairs[static_cast<std::size_t>(next[block]++)] = {static_cast<std::int32_t>(i), static_cast<std::int32_t>(o)};
  });
}

ReducedPattern Structure::MakeReducedPattern(bool diagonal_only) const {
  std::vector<std::vector<std::int32_t>> rows(static_cast<std::size_t>(num_cameras_));
  ParallelForChunks(num_cameras_, 8, [&](Index begin, Index end) {
    std::vector<std::int32_t> seen_in_row(static_cast<std::size_t>(num_cameras_), -1);
    for (Index i = begin; i < end; ++i) {
      const auto camera = static_cast<std::int32_t>(i);
      std::vector<std::int32_t>& row = rows[static_cast<std::size_t>(i)];
      row.push_back(camera);
      if (diagonal_only) continue;
      ForEachPair(i, false, [&](Index, Index o) {
        const std::int32_t j = camera_[o];
        if (j == camera || std::exchange(seen_in_row[static_cast<std::size_t>(j)], camera) == camera) return;
        row.push_back(j);
      });
      std::sort(row.begin() + 1, row.end());
    }
  });
  ReducedPattern pattern;
  pattern.diagonal_only = diagonal_only;
  pattern.row_first.Resize(num_cameras_ + 1);
  for (Index i = 0; i < num_cameras_; ++i) {
    pattern.row_first[i + 1] = pattern.row_first[i] + static_cast<Index>(rows[static_cast<std::size_t>(i)].size());
  }
  pattern.column.Resize(pattern.row_first[num_cameras_]);
  for (Index i = 0; i < num_cameras_; ++i) {
    const auto& row = rows[static_cast<std::size_t>(i)];
    std::copy(row.begin(), row.end(), pattern.column.data() + pattern.row_first[i]);
  }
  pattern.pair_first.Resize(pattern.column.size() + 1);
  ParallelForChunks(num_cameras_, 8, [&](Index begin, Index end) {
    std::vector<std::int32_t> block_of_camera;
    for (Index i = begin; i < end; ++i) {
      NumberBlocks(i, pattern, block_of_camera);
      Index* counts = pattern.pair_first.data() + pattern.row_first[i] + 1;
      ForEachPair(i, diagonal_only,
                  [&](Index, Index o) { ++counts[block_of_camera[static_cast<std::size_t>(camera_[o])]]; });
    }
  });
  for (Index k = 0; k < pattern.column.size(); ++k) pattern.pair_first[k + 1] += pattern.pair_first[k];
  return pattern;
}

}  // namespace vesta::bundle
