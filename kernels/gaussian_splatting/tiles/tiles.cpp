// SPDX-License-Identifier: Apache-2.0
#include "kernels/gaussian_splatting/tiles/tiles.h"

#include <algorithm>
#include <atomic>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/tiles/tile_coverage.h"

namespace vesta::splat {

template <class S>
void TileBins::Build(HostSpan<const Splat<S>> splats, int width, int height) {
  tiles_x_ = (width + kTileSize - 1) / kTileSize;
  tiles_y_ = (height + kTileSize - 1) / kTileSize;
  const Index count = splats.size();
  splat_begin_.Resize(count + 1);
  constexpr Index kGrain = 1024;
  std::atomic<Index> pairs = 0;
  // Finding a splat's tiles costs more than copying them, so each chunk of splats stores them.
  std::vector<std::vector<std::uint32_t>> found(static_cast<std::size_t>((count + kGrain - 1) / kGrain));
  ParallelForChunks(count, kGrain, [&](Index begin, Index end) {
    std::vector<std::uint32_t>& mine = found[static_cast<std::size_t>(begin / kGrain)];
    mine.reserve(static_cast<std::size_t>(8 * kGrain));
    for (Index k = begin; k < end; ++k) {
      const std::size_t before = mine.size();
      VisitTiles(splats[k], tiles_x_, tiles_y_, width, height,
                 [&](int tile) { mine.push_back(static_cast<std::uint32_t>(tile)); });
      splat_begin_[k + 1] = static_cast<std::int64_t>(mine.size() - before);
    }
    pairs += static_cast<Index>(mine.size());
    VESTA_CHECK(pairs < Index{0xffffffff},
                "the splats of one view cover at least {} tiles in total; the limit is 2^32 - 2", pairs.load());
  });
  for (Index k = 0; k < count; ++k) splat_begin_[k + 1] += splat_begin_[k];
  tiles_of_splat_.ResizeForOverwrite(pairs);
  ParallelFor(static_cast<Index>(found.size()), 1, [&](Index chunk) {
    std::vector<std::uint32_t>& mine = found[static_cast<std::size_t>(chunk)];
    std::copy(mine.begin(), mine.end(), tiles_of_splat_.data() + splat_begin_[chunk * kGrain]);
    mine = {};
  });

  // Counting sort by tile that keeps the depth order. Slices of the splats count and place their own entries, one after
  // the other in each tile, so the result does not depend on the number of slices.
  const Index slices = std::clamp<Index>(count / 4096, 1, 16);
  const Index tiles = num_tiles();
  std::vector<std::uint32_t> cursor(static_cast<std::size_t>(slices * tiles), 0);
  const auto slice_begin = [&](Index slice) { return count * slice / slices; };
  ParallelFor(slices, 1, [&](Index slice) {
    std::uint32_t* mine = cursor.data() + slice * tiles;
    for (Index e = splat_begin_[slice_begin(slice)]; e < splat_begin_[slice_begin(slice + 1)]; ++e) {
      ++mine[tiles_of_splat_[e]];
    }
  });
  tile_begin_.ResizeForOverwrite(tiles + 1);
  std::uint32_t first = 0;
  for (Index tile = 0; tile < tiles; ++tile) {
    tile_begin_[tile] = first;
    for (Index slice = 0; slice < slices; ++slice)
      first += std::exchange(cursor[static_cast<std::size_t>(slice * tiles + tile)], first);
  }
  tile_begin_[tiles] = first;
  ranks_.ResizeForOverwrite(pairs);
  pairs_of_splat_.ResizeForOverwrite(pairs);
  ParallelFor(slices, 1, [&](Index slice) {
    std::uint32_t* mine = cursor.data() + slice * tiles;
    for (Index k = slice_begin(slice); k < slice_begin(slice + 1); ++k) {
      for (Index e = splat_begin_[k]; e < splat_begin_[k + 1]; ++e) {
        const std::uint32_t pair = mine[tiles_of_splat_[e]]++;
        ranks_[pair] = static_cast<std::uint32_t>(k);
        pairs_of_splat_[e] = pair;
      }
    }
  });
}

template void TileBins::Build(HostSpan<const Splat<float>>, int, int);
template void TileBins::Build(HostSpan<const Splat<double>>, int, int);

}  // namespace vesta::splat
