// SPDX-License-Identifier: Apache-2.0
// Block kernels (kernels/core/block_kernel.h) for wide splats, which touch many tiles (tile_pairs.h). All threads of a
// block together list the tiles of one splat, or sum its records. With one thread per splat, the other threads would
// wait for the thread of a wide splat.
#pragma once

#include "kernels/core/block_kernel.h"
#include "kernels/gaussian_splatting/tiles/tile_pairs.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// Number of slots. Each wide splat has its own slot. It has more than kFewTiles entries, so the index of one of them is
// a multiple of kFewTiles. The first such index, divided by kFewTiles, is its slot. A slot contains 1 + rank, or 0 if
// empty.
constexpr Index NumWideSlots(Index pairs) { return pairs / kFewTiles + 1; }

// For rank r: stores 1 + r in the slot of a wide splat. slots must be 0 before.
struct MarkWideSplats {
  const Index* splat_begin;
  std::uint32_t* slots;

  VESTA_HD void operator()(Index r) const {
    if (IsWide(splat_begin, r)) slots[(splat_begin[r] + kFewTiles - 1) / kFewTiles] = static_cast<std::uint32_t>(r + 1);
  }
};

inline constexpr int kWideThreads = 256;

// Each block of threads processes kWideThreads slots.
struct WideSlots {
  const std::uint32_t* slots;
  Index count;

  static constexpr Index NumBlocks(Index count) { return (count + kWideThreads - 1) / kWideThreads; }

  // Calls visit(rank), with all threads, for each splat in the slots of the block. A barrier precedes each call. mine:
  // shared memory.
  template <class Block, class Visit>
  VESTA_HD void ForEach(Block& block, std::uint32_t (&mine)[kWideThreads], const Visit& visit) const {
    const Index at = block.id() * kWideThreads + block.thread();
    mine[block.thread()] = at < count ? slots[at] : 0;
    block.Sync();
    for (int i = 0; i < kWideThreads; ++i) {
      if (mine[i] == 0) continue;
      visit(Index{mine[i]} - 1);
      block.Sync();
    }
  }
};

// EmitPairs for wide splats. A thread processes one row of tiles at a time.
template <class S>
struct EmitWidePairs {
  static constexpr int kThreads = kWideThreads;
  struct Shared {
    std::uint32_t slots[kThreads];
    Index begin[kThreads + 1];  // first entry of each row
  };
  WideSlots wide;
  TileGrid grid;
  const Splat<S>* splats;
  const Index* splat_begin;
  PairArrays pairs;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const int thread = block.thread();
    wide.ForEach(block, shared.slots, [&](Index r) {
      const TileRows<S> rows(splats[r], grid.tiles_x, grid.tiles_y, grid.width, grid.height);
      Index begin = splat_begin[r];
      for (int first_row = rows.begin; first_row < rows.end; first_row += kThreads) {
        const int row = first_row + thread;
        shared.begin[thread + 1] = row < rows.end ? rows.CountIn(row) : 0;
        block.Sync();
        if (thread == 0) {
          shared.begin[0] = begin;
          for (int i = 0; i < kThreads; ++i) shared.begin[i + 1] += shared.begin[i];
        }
        block.Sync();
        Emit(rows, row, r, shared.begin[thread]);
        begin = shared.begin[kThreads];
        block.Sync();
      }
    });
  }

 private:
  VESTA_HD void Emit(const TileRows<S>& rows, int row, Index r, Index e) const {
    int first = 0, last = 0;
    if (row >= rows.end || !rows.Row(row, &first, &last)) return;
    for (int column = first; column <= last; ++column) pairs.Write(e++, row * grid.tiles_x + column, r);
  }
};

// SumEntries for wide splats. kN threads, one per component, form a lane. Lane l adds the entries l, l + kLanes, ...,
// in the order of the tiles. The sums of the lanes are then added in order, so the result is bit-identical in every
// run.
template <class S, int kN>
struct SumWideBlock {
  static constexpr int kThreads = kWideThreads, kLanes = kThreads / kN;
  struct Shared {
    std::uint32_t slots[kThreads];
    S lanes[kLanes][kN];
  };
  WideSlots wide;
  const Index* splat_begin;
  const S* records;
  S* sums;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const int lane = block.thread() / kN, component = block.thread() % kN;
    wide.ForEach(block, shared.slots, [&](Index r) {
      if (lane < kLanes) {
        S sum(0);
        const Index end = splat_begin[r + 1];
        for (Index begin = splat_begin[r] + lane; begin < end; begin += Index{kTermsPerPartialSum} * kLanes) {
          const Index part_end = Min(begin + Index{kTermsPerPartialSum} * kLanes, end);
          S part(0);
          for (Index e = begin; e < part_end; e += kLanes) part += records[kN * e + component];
          sum += part;
        }
        shared.lanes[lane][component] = sum;
      }
      block.Sync();
      if (lane > 0) return;
      S total(0);
      for (const S(&of_lane)[kN] : shared.lanes) total += of_lane[component];
      sums[kN * r + component] = total;
    });
  }
};

}  // namespace VESTA_ISA
}  // namespace vesta::splat
