// SPDX-License-Identifier: Apache-2.0
// Common parts of the block kernels over tiles (kernels/core/block_kernel.h). Each tile has one block of threads and
// each pixel one thread. The tile's splats are visited in batches in shared memory. A pair is a splat and a tile that
// it touches (TileLists). The host's counterparts are traverse_rows.h and traverse_splats.h.
#pragma once

#include "kernels/core/block_kernel.h"
#include "kernels/gaussian_splatting/formulas/pixel_steps.h"
#include "kernels/gaussian_splatting/tiles/row_span.h"
#include "kernels/gaussian_splatting/tiles/tile_coverage.h"
#include "kernels/math/device_scalar.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

inline constexpr int kRasterThreads = kTileSize * kTileSize, kRasterWarps = kRasterThreads / 32;
// A warp covers 8 x 4 pixels. This shape is compact, so that a splat touches few warps.
inline constexpr int kWarpColumns = 8, kWarpRows = 4;

// An int, because divisions of int are faster.
template <class Block>
VESTA_HD inline int TileOf(const Block& block) {
  return static_cast<int>(block.id());
}

// The pixel of a thread.
struct BlockPixel {
  int x, y;                 // position in the tile
  bool inside;              // whether it is inside the image
  std::int64_t index;       // in a plane (one colour channel) of the image
  std::int64_t plane_size;  // pixels of a plane

  template <class S>
  VESTA_HD BlockPixel(const TileLists<S>& lists, int tile, int thread) {
    const int warp = thread / 32, lane = thread % 32;
    x = warp % 2 * kWarpColumns + lane % kWarpColumns;
    y = warp / 2 * kWarpRows + lane / kWarpColumns;
    const int column = tile % lists.tiles_x * kTileSize + x, row = tile / lists.tiles_x * kTileSize + y;
    inside = column < lists.width && row < lists.height;
    index = std::int64_t{row} * lists.width + column;
    plane_size = std::int64_t{lists.width} * lists.height;
  }
  VESTA_HD int in_tile() const { return y * kTileSize + x; }
  // Value of channel c of an image; 0 outside the image. Store ignores pixels outside.
  template <class S>
  VESTA_HD S Load(const S* image, int c) const {
    return inside ? image[c * plane_size + index] : S(0);
  }
  template <class S>
  VESTA_HD void Store(S* image, int c, const S& value) const {
    if (inside) image[c * plane_size + index] = value;
  }
};

// Blending state of a pixel, from front to back.
template <class S>
struct PixelBlending {
  S transmittance = S(1);  // behind the last splat that contributes to the pixel
  bool open;

  VESTA_HD explicit PixelBlending(const BlockPixel& pixel) : open(pixel.inside) {}
  // Blends the next splat (from InTile). Calls hit(p, q, blend) if its alpha at the pixel is at least 1/255; (p, q) are
  // the pixel's whitened coordinates (row_span.h). A splat that would reduce the transmittance below 1e-4 closes the
  // pixel: blend.alpha is then 0, and no later splat is blended.
  template <class Hit>
  VESTA_HD void BlendNext(const BlockPixel& pixel, const Splat<S>& splat, const Hit& hit) {
    const RowSpan<S> row = RowInTile(splat, pixel.y);
    const S p = OffsetAt(static_cast<S>(pixel.x), splat.r, row.p0), alpha = AlphaAt(p, row.peak);
    if (!(alpha > S(0))) return;
    const Blend<S> blend = BlendSplat(transmittance, alpha);
    open = blend.open;
    if (open) transmittance = blend.transmittance;
    hit(p, row.q, blend);
  }
};

// Bit w is set if the support of the splat (from InTile) touches the pixels of warp w. Otherwise alpha is 0 in warp w.
template <class S>
VESTA_HD inline std::uint32_t WarpsInReach(const Splat<S>& splat) {
  const SupportReach<S> reach(splat);
  std::uint32_t warps = 0;
  for (int row = 0; row < kTileSize; row += kWarpRows) {
    const S y0 = Max(static_cast<S>(row), splat.v - reach.y);
    const S y1 = Min(static_cast<S>(row + kWarpRows - 1), splat.v + reach.y);
    if (!(y0 <= y1)) continue;
    const S left = ExtremeX(splat, reach, y0, y1, S(-1)), right = ExtremeX(splat, reach, y0, y1, S(1));
    for (int half = 0; half < 2; ++half) {
      const int begin = half * kWarpColumns, end = begin + kWarpColumns - 1;
      if (right >= static_cast<S>(begin) && left <= static_cast<S>(end)) warps |= 1U << (row / kWarpRows * 2 + half);
    }
  }
  return warps;
}

// A batch of a tile's splats in shared memory, and the warps that each splat touches.
template <class S, int kBatch>
struct SplatBatch {
  Splat<S> splats[kBatch];
  std::uint8_t warps[kBatch];

  VESTA_HD const Splat<S>& operator[](int k) const { return splats[k]; }
  VESTA_HD bool Touches(int k, int warp) const { return (warps[k] >> warp & 1U) != 0; }

  // Loads the splats of the pairs first .. first + count - 1. Call Sync before and after it.
  template <class Block>
  VESTA_HD void Stage(Block& block, const TileLists<S>& lists, std::int64_t first, int count) {
    const int k = block.thread();
    if (k >= count) return;
    splats[k] = InTile(lists.splats[lists.ranks[first + k]], TileOrigin<S>(lists, TileOf(block)));
    warps[k] = static_cast<std::uint8_t>(WarpsInReach(splats[k]));
  }
};

// A SplatBatch with a mask per warp. The mask selects the splats that touch the warp.
template <class S, int kBatch>
struct MaskedSplatBatch : SplatBatch<S, kBatch> {
  static constexpr int kWords = (kBatch + 31) / 32;
  std::uint32_t masks[kRasterWarps][kWords];  // bit k % 32 of word k / 32: splat k

  // Call Sync between Stage and ComputeMasks, and after ComputeMasks.
  template <class Block>
  VESTA_HD void ComputeMasks(Block& block, int count) {
    if (block.thread() >= kRasterWarps * kWords) return;
    const int warp = block.thread() % kRasterWarps, word = block.thread() / kRasterWarps;
    std::uint32_t bits = 0;
    for (int k = 32 * word; k < count && k < 32 * (word + 1); ++k) {
      bits |= (this->Touches(k, warp) ? 1U : 0U) << k % 32;
    }
    masks[warp][word] = bits;
  }
};

// end - first, but at most max_size.
VESTA_HD inline int BatchSize(std::int64_t first, std::int64_t end, int max_size) {
  return end - first < max_size ? static_cast<int>(end - first) : max_size;
}

// Calls visit(first, count) for the pairs of the block's tile, at most kBatch pairs at a time, while go_on() is true.
// go_on must contain a barrier, so that visit may overwrite the shared memory. Returns the first pair not visited.
template <int kBatch, class S, class Block, class GoOn, class Visit>
VESTA_HD inline std::int64_t ForEachBatch(Block& block, const TileLists<S>& lists, const GoOn& go_on,
                                          const Visit& visit) {
  const std::int64_t end = lists.tile_begin[block.id() + 1];
  std::int64_t first = lists.tile_begin[block.id()];
  for (; first < end; first += kBatch) {
    if (!go_on()) break;
    visit(first, BatchSize(first, end, kBatch));
  }
  return first;
}

// For passes that sum over splats: calls hit(k, p, q, blend) for each splat splats[k] that contributes to the thread's
// pixel, front to back until the pixel is closed. stage(first, count) loads further data for each batch.
template <int kBatch, class S, class Block, class Stage, class Hit>
VESTA_HD inline void ForEachHit(Block& block, const TileLists<S>& lists, const BlockPixel& pixel,
                                PixelBlending<S>& blending, MaskedSplatBatch<S, kBatch>& splats, const Stage& stage,
                                const Hit& hit) {
  ForEachBatch<kBatch>(
      block, lists, [&] { return block.Count(blending.open) != 0; },
      [&](std::int64_t first, int count) {
        stage(first, count);
        splats.Stage(block, lists, first, count);
        block.Sync();
        splats.ComputeMasks(block, count);
        block.Sync();
        const std::uint32_t* mine = splats.masks[block.thread() / 32];
        for (int word = 0; 32 * word < count; ++word) {
          for (std::uint32_t bits = mine[word]; bits != 0 && blending.open; bits &= bits - 1) {
            const int k = 32 * word + LowestBit(bits);
            blending.BlendNext(pixel, splats[k],
                               [&](const S& p, const S& q, const Blend<S>& blend) { hit(k, p, q, blend); });
          }
        }
      });
}

// For passes that sum over the pixels of each splat. For each splat k of a batch, every thread calls put(k, share) with
// its pixel's share: share_of(k, blend) if the splat contributes to the pixel, else Share{}. All threads then call
// sum(first, count), which must add the shares. Returns the first pair not summed because all pixels were closed.
template <class Share, int kBatch, class S, class Block, class ShareOf, class Put, class Sum>
VESTA_HD inline std::int64_t SumOverPixels(Block& block, const TileLists<S>& lists, const BlockPixel& pixel,
                                           SplatBatch<S, kBatch>& splats, const ShareOf& share_of, const Put& put,
                                           const Sum& sum) {
  PixelBlending<S> blending(pixel);
  const int warp = block.thread() / 32;
  return ForEachBatch<kBatch>(
      block, lists, [&] { return block.Count(blending.open) != 0; },
      [&](std::int64_t first, int count) {
        splats.Stage(block, lists, first, count);
        block.Sync();
        for (int k = 0; k < count; ++k) {
          Share share{};
          if (blending.open && splats.Touches(k, warp)) {
            blending.BlendNext(pixel, splats[k],
                               [&](const S&, const S&, const Blend<S>& blend) { share = share_of(k, blend); });
          }
          put(k, share);
        }
        block.Sync();
        sum(first, count);
      });
}

// Calls visit(pair, i) for 0 <= i < kN and all pairs from `first` to the last one of the block's tile. The calls are
// divided among all threads.
template <int kN, class S, class Block, class Visit>
VESTA_HD inline void ForEachRemaining(Block& block, const TileLists<S>& lists, std::int64_t first, const Visit& visit) {
  const std::int64_t end = lists.tile_begin[block.id() + 1];
  for (std::int64_t i = first * kN + block.thread(); i < end * kN; i += kRasterThreads) {
    visit(i / kN, static_cast<int>(i % kN));
  }
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
