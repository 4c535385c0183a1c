// SPDX-License-Identifier: Apache-2.0
// The observations of a bundle adjustment in camera order and track order (kernels.h).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "kernels/core/buffer.h"
#include "problems/bundle_adjustment/bal_file.h"
#include "problems/bundle_adjustment/kernels.h"

namespace vesta::bundle {

// The nonzero blocks (i, j), i <= j, of the reduced matrix: those whose cameras i and j observe a common point.
struct ReducedPattern {
  bool diagonal_only = true;        // contains only the blocks (i, i)
  HostBuffer<Index> row_first;      // row i has the blocks row_first[i]..row_first[i + 1] - 1, columns ascending from i
  HostBuffer<std::int32_t> column;  // column of each block
  // Block k is the sum over the pairs pair_first[k]..pair_first[k + 1] - 1: two observations of one point, one by each
  // camera.
  HostBuffer<Index> pair_first;
};

class Structure {
 public:
  // Throws Error for indices out of range and inconsistent sizes.
  explicit Structure(const BundleData& data);

  Index num_cameras() const { return num_cameras_; }
  Index num_points() const { return num_points_; }
  Index num_observations() const { return camera_.size(); }
  Index num_camera_parameters() const { return kCameraSize * num_cameras_; }
  Index num_parameters() const { return num_camera_parameters() + kPointSize * num_points_; }
  Index longest_track() const { return longest_track_; }
  // Sum of k (k + 1) / 2 over points with k observations.
  Index num_pairs() const { return num_pairs_; }

  // Track order: track k has the observations track_first()[k]..track_first()[k + 1] - 1 of the point track_point()[k];
  // camera()[o] is the camera of observation o.
  const Index* track_first() const { return track_first_.data(); }
  const std::int32_t* track_point() const { return track_point_.data(); }
  const std::int32_t* camera() const { return camera_.data(); }
  // Chunks of tracks have about the same number of observations, and do not depend on the number of threads. Chunk k
  // has the tracks chunk_first(k)..chunk_first(k + 1) - 1.
  Index num_chunks() const { return static_cast<Index>(chunk_first_.size()) - 1; }
  Index chunk_first(Index chunk) const { return chunk_first_[static_cast<std::size_t>(chunk)]; }

  // Camera order: each camera's observations are divided into slices of at most kSliceSize.
  static constexpr Index kSliceSize = 1024;
  Index num_slices() const { return static_cast<Index>(slice_camera_.size()); }
  Index slice_camera(Index slice) const { return slice_camera_[static_cast<std::size_t>(slice)]; }
  CameraSlice slice(Index slice) const;
  // Camera i has the slices first_slice(i)..first_slice(i + 1) - 1.
  Index first_slice(Index camera) const { return first_slice_[static_cast<std::size_t>(camera)]; }
  CameraSlice camera_observations(Index camera) const;

  // The block pattern of the reduced matrix, or only its diagonal. Takes about num_pairs() steps.
  ReducedPattern MakeReducedPattern(bool diagonal_only) const;
  // Lists the pairs of observations for row `camera` of the matrix. Block k of the pattern has the pairs
  // first[b]..first[b + 1] - 1, with b = k - row_first[camera].
  void ListPairs(Index camera, const ReducedPattern& pattern, std::vector<Index>& first,
                 std::vector<ObservationPair>& pairs) const;

 private:
  CameraSlice Range(Index begin, Index end) const;
  // block_of_camera[j] = index, within row `camera`, of the block in column j.
  void NumberBlocks(Index camera, const ReducedPattern& pattern, std::vector<std::int32_t>& block_of_camera) const;
  // Calls body(own, other) (ObservationPair) for each pair of row `camera`.
  template <class Body>
  void ForEachPair(Index camera, bool diagonal_only, const Body& body) const;

  Index num_cameras_, num_points_, longest_track_ = 0, num_pairs_ = 0;
  HostBuffer<Index> track_first_, camera_first_;
  HostBuffer<std::int32_t> track_point_, camera_, position_, point_, track_;
  HostBuffer<double> observed_;
  std::vector<Index> chunk_first_, slice_camera_, slice_begin_, first_slice_;
};

}  // namespace vesta::bundle
