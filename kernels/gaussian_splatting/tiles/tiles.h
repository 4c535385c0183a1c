// SPDX-License-Identifier: Apache-2.0
// Lists of the splats that touch each tile, on the CPU.
#pragma once

#include "kernels/core/buffer.h"
#include "kernels/gaussian_splatting/formulas/types.h"

namespace vesta::splat {

// The (splat, tile) pairs of one view. A pair is an index into the lists of the tiles, which are ordered by tile and
// then by rank. The rank of a splat is its index in depth order. pairs_of_splat lists the pairs of each splat.
class TileBins {
 public:
  // splats: in depth order. A splat is listed in a tile if the ellipse of its support (Splat::support) intersects the
  // rectangle of the tile's pixel centres. Runs in parallel; the lists do not depend on the number of threads.
  template <class S>
  void Build(HostSpan<const Splat<S>> splats, int width, int height);

  int tiles_x() const { return tiles_x_; }
  int tiles_y() const { return tiles_y_; }
  int num_tiles() const { return tiles_x_ * tiles_y_; }
  Index num_splats() const { return splat_begin_.size() - 1; }
  Index num_pairs() const { return ranks_.size(); }
  // [num_tiles + 1] first pair of each tile.
  const std::int64_t* tile_begin() const { return tile_begin_.data(); }
  // [num_pairs] rank of the splat, ascending within a tile.
  const std::uint32_t* ranks() const { return ranks_.data(); }
  // [num_splats + 1] first index of each splat in pairs_of_splat.
  const std::int64_t* splat_begin() const { return splat_begin_.data(); }
  // [num_pairs] the pairs of each splat, by ascending tile.
  const std::uint32_t* pairs_of_splat() const { return pairs_of_splat_.data(); }
  // [num_pairs] tile of each element of pairs_of_splat.
  const std::uint32_t* tiles_of_splat() const { return tiles_of_splat_.data(); }

  // Bytes of the lists of a view.
  static double Bytes(const ViewCounts& view) {
    return sizeof(std::int64_t) * (view.tiles + view.splats) + 3 * sizeof(std::uint32_t) * view.pairs;
  }

 private:
  int tiles_x_ = 0, tiles_y_ = 0;
  HostBuffer<std::int64_t> tile_begin_, splat_begin_;
  HostBuffer<std::uint32_t> ranks_, pairs_of_splat_, tiles_of_splat_;
};

}  // namespace vesta::splat
