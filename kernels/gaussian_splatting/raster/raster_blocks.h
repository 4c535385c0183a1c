// SPDX-License-Identifier: Apache-2.0
// The raster passes as block kernels (kernels/core/block_kernel.h). Each tile has one block of threads, each pixel one
// thread. The kernels use the formulas of passes.h and the traversal of tile_block.h. S is float on a device; tests run
// double on the host.
//
// Forward and tangent passes sum over splats and keep the sums of a pixel in registers. Adjoint and Gram passes sum
// over the pixels of each splat, a few splats at a time, without atomics. First, each thread writes the contributions
// of the splats at its pixel to shared memory. Then each thread sums the contributions to one splat from one row, or
// half a row, of pixels.
#pragma once

#include "kernels/gaussian_splatting/raster/splat_sums.h"
#include "kernels/gaussian_splatting/tiles/tile_block.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// GPU version of RasterKernels::forward.
template <class S>
struct ForwardBlock {
  static constexpr int kThreads = kRasterThreads, kBatch = kRasterThreads;
  struct Shared {
    MaskedSplatBatch<S, kBatch> splats;
  };
  TileLists<S> lists;
  S* image;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const BlockPixel pixel(lists, TileOf(block), block.thread());
    PixelBlending<S> blending(pixel);
    S color[3] = {S(0), S(0), S(0)};
    ForEachHit(
        block, lists, pixel, blending, shared.splats, [](std::int64_t, int) {},
        [&](int k, const S&, const S&, const Blend<S>& blend) {
          for (int c = 0; c < 3; ++c) color[c] = Fma(blend.weight, shared.splats[k].color[c], color[c]);
        });
    for (int c = 0; c < 3; ++c) {
      pixel.Store(image, c, Fma(blending.transmittance, lists.background[c], color[c]));
    }
  }
};

// GPU version of RasterKernels::tangent.
template <class S>
struct TangentBlock {
  static constexpr int kThreads = kRasterThreads, kBatch = kRasterThreads;
  struct Shared {
    MaskedSplatBatch<S, kBatch> splats;
    SplatTangent<S> tangents[kBatch];
  };
  TileLists<S> lists;
  const SplatTangent<S>* tangents;
  S* d_image;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const BlockPixel pixel(lists, TileOf(block), block.thread());
    PixelBlending<S> blending(pixel);
    S d_color[3] = {S(0), S(0), S(0)}, minus_dT(0);
    ForEachHit(
        block, lists, pixel, blending, shared.splats,
        [&](std::int64_t first, int count) {
          const int k = block.thread();
          if (k < count) shared.tangents[k] = tangents[lists.ranks[first + k]];
        },
        [&](int k, const S& p, const S& q, const Blend<S>& blend) {
          const SplatTangent<S>& tangent = shared.tangents[k];
          const S* color = shared.splats[k].color;
          const S d_weight = TangentWeight(blend, Psi(tangent, p, q), minus_dT);
          for (int c = 0; c < 3; ++c) {
            d_color[c] = TangentColor(blend, d_weight, color[c], tangent.w[kColor + c], d_color[c]);
          }
        });
    for (int c = 0; c < 3; ++c) pixel.Store(d_image, c, Fnma(minus_dT, lists.background[c], d_color[c]));
  }
};

// GPU version of RasterKernels::adjoint. The sums of pair k of the lists are stored in sums[entries[k]]. entries[k]:
// index of pair k in the order by splat.
template <class S>
struct AdjointBlock {
  static constexpr int kThreads = kRasterThreads, kBatch = 16;
  struct Share {
    S g, w;  // derivatives of the pixel's part of u . image with respect to log alpha and u . c
  };
  struct Shared {
    SplatBatch<S, kBatch> splats;
    S u[3][kRasterThreads];
    Share shares[kBatch][kRasterThreads];
    S rows[kBatch][kTileSize][kCotangentRowSums];
  };
  TileLists<S> lists;
  const std::uint32_t* entries;
  const S *image, *u;
  SplatTangent<S>* sums;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const int thread = block.thread();
    const BlockPixel pixel(lists, TileOf(block), thread);
    S behind(0), my_u[3];
    for (int c = 0; c < 3; ++c) {
      my_u[c] = pixel.Load(u, c);
      behind += my_u[c] * pixel.Load(image, c);
      shared.u[c][IndexInU(pixel.x, pixel.y)] = my_u[c];
    }
    const std::int64_t remaining = SumOverPixels<Share>(
        block, lists, pixel, shared.splats,
        [&](int k, const Blend<S>& blend) {
          const S share = ContributionOf(blend, shared.splats[k].color, my_u);
          return Share{ByLogAlpha(blend, AlphaOdds(blend.alpha), share, behind), blend.weight};
        },
        [&](int k, const Share& share) { shared.shares[k][IndexInShares(pixel.x, pixel.y)] = share; },
        [&](std::int64_t first, int count) {
          if (thread / kTileSize < count) AddRow(shared, thread / kTileSize, thread % kTileSize);
          block.Sync();
          if (thread < count * kSplatSums) {
            const int k = thread / kSplatSums, i = thread % kSplatSums;
            sums[entries[first + k]].w[i] = CotangentFromRows(shared.splats[k], shared.rows[k], k, i);
          }
        });
    ForEachRemaining<kSplatSums>(block, lists, remaining,
                                 [&](std::int64_t pair, int i) { sums[entries[pair]].w[i] = S(0); });
  }

 private:
  // Rows are rotated to avoid bank conflicts: the pixels of half a warp (two rows of eight) are in different banks, and
  // so are the pixels of a column.
  VESTA_HD static int IndexInShares(int x, int y) { return y * kTileSize + (x + y % 2 * 8 + y / 2) % kTileSize; }
  VESTA_HD static int IndexInU(int x, int y) { return y * kTileSize + (x + y) % kTileSize; }

  VESTA_HD void AddRow(Shared& shared, int k, int y) const {
    const Splat<S>& splat = shared.splats[k];
    const RowSpan<S> row = RowInTile(splat, y);
    const PixelRange reached = row.PixelsIn(0, kTileSize - 1);
    CotangentRow<S> total;
    for (int x = reached.begin; x < reached.end; ++x) {
      const Share& share = shared.shares[k][IndexInShares(x, y)];
      for (int c = 0; c < 3; ++c) total.AddColor(c, share.w, shared.u[c][IndexInU(x, y)]);
      const S p = OffsetAt(static_cast<S>(x), splat.r, row.p0);
      total.AddShape(share.g, p);
      total.AddPull(share.g, p);
    }
    for (int i = 0; i < kCotangentRowSums; ++i) shared.rows[k][y][PlaceOfRowSum(k, y, i)] = total.sum[i];
  }
};

// GPU version of RasterKernels::gram. sums, entries: see AdjointBlock.
template <class S>
struct GramBlock {
  // Two threads per row.
  static constexpr int kThreads = kRasterThreads, kBatch = 8, kParts = 2 * kTileSize, kHalf = kTileSize / 2;
  struct alignas(16) Share {
    S w, d[3];  // derivatives of the pixel's colours with respect to the splat's colour and log alpha
  };
  struct Shared {
    SplatBatch<S, kBatch> splats;
    S omega[3][kRasterThreads];
    S powers[kBatch][kTileSize][kRowPowers];
    union {
      Share shares[kBatch][kRasterThreads];
      S parts[kBatch][kParts][GramRow<S>::kSums];
    };
  };
  TileLists<S> lists;
  const std::uint32_t* entries;
  const S *image, *omega;
  SplatGram<S>* sums;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const int thread = block.thread();
    const BlockPixel pixel(lists, TileOf(block), thread);
    S behind[3];
    for (int c = 0; c < 3; ++c) {
      behind[c] = pixel.Load(image, c);
      shared.omega[c][PixelIndex(pixel.x, pixel.y)] = pixel.Load(omega, c);
    }
    const std::int64_t remaining = SumOverPixels<Share>(
        block, lists, pixel, shared.splats,
        [&](int k, const Blend<S>& blend) {
          const S odds = AlphaOdds(blend.alpha), *color = shared.splats[k].color;
          Share share;
          share.w = blend.weight;
          for (int c = 0; c < 3; ++c) share.d[c] = ByLogAlpha(blend, odds, blend.weight * color[c], behind[c]);
          return share;
        },
        [&](int k, const Share& share) { shared.shares[k][PixelIndex(pixel.x, pixel.y)] = share; },
        [&](std::int64_t first, int count) {
          GramRow<S> part;
          const int k = thread / kParts;
          if (k < count) {
            AddHalfRow(shared, k, thread % kParts, part);
            if (const int y = thread % kParts; y < kTileSize) {
              PowersOfRow(RowInTile(shared.splats[k], y).q, shared.powers[k][y]);
            }
          }
          block.Sync();  // the parts overwrite the shares
          if (k < count) {
            for (int i = 0; i < GramRow<S>::kSums; ++i) shared.parts[k][thread % kParts][i] = part.sum[i];
          }
          block.Sync();
          for (int i = thread; i < count * kGramSums; i += kThreads) {
            const int of = i / kGramSums;
            sums[entries[first + of]].m[i % kGramSums] =
                GramSumFromRows(shared.powers[of], shared.parts[of], i % kGramSums);
          }
        });
    ForEachRemaining<kGramSums>(block, lists, remaining,
                                [&](std::int64_t pair, int i) { sums[entries[pair]].m[i] = S(0); });
  }

 private:
  // Half rows are rotated to avoid bank conflicts between eight neighbouring threads, each at the same pixel of its own
  // half row.
  VESTA_HD static int PixelIndex(int x, int y) {
    const int half = x / kHalf;
    return y * kTileSize + half * kHalf + (x + 2 * y + half) % kHalf;
  }

  VESTA_HD void AddHalfRow(const Shared& shared, int k, int index, GramRow<S>& part) const {
    const Splat<S>& splat = shared.splats[k];
    const int y = index / 2, first = index % 2 * kHalf;
    const RowSpan<S> row = RowInTile(splat, y);
    const PixelRange reached = row.PixelsIn(first, first + kHalf - 1);
    for (int x = reached.begin; x < reached.end; ++x) {
      const int at = PixelIndex(x, y);
      const Share& share = shared.shares[k][at];
      part.Add(share.w, OffsetAt(static_cast<S>(x), splat.r, row.p0), [&](int c) {
        return GramColor<S>{shared.omega[c][at], share.d[c]};
      });
    }
  }
};

}  // namespace VESTA_ISA
}  // namespace vesta::splat
