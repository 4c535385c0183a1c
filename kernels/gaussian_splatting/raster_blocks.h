// The raster passes for a GPU as block kernels (kernels/core/block_kernel.h): one block a tile, one thread a pixel. The
// formulas are those of pixel_steps.h; what is here is who does what when. S is float on a device; tests run double on
// the host.
//
// Forward and tangent keep all they need in registers. Adjoint and Gram need sums over the pixels for each splat, and
// get them in the tile without atomics, and without shuffles in the inner loop: for a few splats at a time the threads
// write, as pixels, what each splat means to their pixel into shared memory, and add it up, as splats and rows. Along a
// row q is constant, so that sums of powers of p suffice, and those of the rows are weighed with powers of q at the
// end.
#pragma once

#include "kernels/core/block_kernel.h"
#include "kernels/gaussian_splatting/pixel_steps.h"
#include "kernels/gaussian_splatting/row_span.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

inline constexpr int kRasterThreads = kTileSize * kTileSize;

// The rows of a tile in the order in which threads take them: those that are looked at come first, so that where few
// are, whole warps have nothing to do.
VESTA_HD inline int RowInOrder(std::uint32_t looked_at, int place) {
  int kept = 0;
  for (int y = 0; y < kTileSize; ++y) kept += static_cast<int>(looked_at >> y & 1U);
  const bool among_kept = place < kept;
  int left = among_kept ? place : place - kept;
  for (int y = 0; y < kTileSize; ++y) {
    if (((looked_at >> y & 1U) != 0) == among_kept && left-- == 0) return y;
  }
  return place;  // never: there are sixteen
}

// The pixel of a thread. A warp takes 8 x 4 pixels: the more compact, the fewer warps does a splat concern.
struct BlockPixel {
  int x, y;            // in the tile
  bool inside;         // the image
  bool looked_at;      // inside, and its row is (TileLists::rows); others count as closed
  std::int64_t place;  // in a plane of the image

  template <class S>
  VESTA_HD BlockPixel(const TileLists<S>& lists, std::int64_t tile, int thread) {
    const int warp = thread / 32, lane = thread % 32;
    x = warp % 2 * 8 + lane % 8;
    y = warp / 2 * 4 + lane / 8;
    const std::uint32_t rows = lists.rows == nullptr ? 0xffffU : lists.rows[tile];
    if (rows != 0xffffU) y = RowInOrder(rows, y);
    const std::int64_t column = tile % lists.tiles_x * kTileSize + x, row = tile / lists.tiles_x * kTileSize + y;
    inside = column < lists.width && row < lists.height;
    looked_at = inside && (rows >> y & 1U) != 0;
    place = row * lists.width + column;
  }
  VESTA_HD int in_tile() const { return y * kTileSize + x; }
};

// A splat with its mean relative to the centre of the tile's first pixel.
template <class S>
VESTA_HD inline Splat<S> InTile(const TileLists<S>& lists, std::int64_t tile, const Splat<S>& splat) {
  Splat<S> moved = splat;
  const std::int64_t left = tile % lists.tiles_x * kTileSize, top = tile / lists.tiles_x * kTileSize;
  moved.u = splat.u - (static_cast<S>(left) + S(0.5));
  moved.v = splat.v - (static_cast<S>(top) + S(0.5));
  return moved;
}

// A splat of InTile on row y of the tile. What is not used of it costs nothing.
template <class S>
VESTA_HD inline RowSpan<S> RowInTile(const Splat<S>& splat, int y) {
  const RowSplat<S> members = {splat.u,       splat.v,    splat.r, splat.s, splat.beta, splat.log2_opacity,
                               splat.support, splat.inv_r};
  return RowSpan<S>(members, static_cast<S>(y));
}

// What passes to a pixel.
template <class S>
struct Passing {
  S transmittance = S(1);  // behind the last splat that is part of the pixel
  bool open;

  VESTA_HD explicit Passing(const BlockPixel& pixel) : open(pixel.looked_at) {}
  VESTA_HD Blend<S> Take(const S& alpha) {
    const Blend<S> blend = BlendSplat(transmittance, alpha);
    open = blend.open;
    if (open) transmittance = blend.transmittance;
    return blend;
  }
};

// Brings the splats of the pairs [first, first + count) into shared memory. Barriers lie on both sides: the one before
// is the caller's.
template <class S, class Block>
VESTA_HD inline void StageSplats(Block& block, const TileLists<S>& lists, std::int64_t first, int count,
                                 Splat<S>* staged) {
  if (block.thread() < count) {
    staged[block.thread()] = InTile(lists, block.id(), lists.splats[lists.ranks[first + block.thread()]]);
  }
  block.Sync();
}

// Pairs left to do, at most `most`.
VESTA_HD inline int BatchSize(std::int64_t first, std::int64_t end, int most) {
  return end - first < most ? static_cast<int>(end - first) : most;
}

// RasterKernels::forward.
template <class S>
struct ForwardBlock {
  static constexpr int kThreads = kRasterThreads, kBatch = kRasterThreads;
  struct Shared {
    Splat<S> splats[kBatch];
  };
  TileLists<S> lists;
  S* image;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const BlockPixel pixel(lists, block.id(), block.thread());
    Passing<S> passing(pixel);
    S color[3] = {S(0), S(0), S(0)};
    const std::int64_t end = lists.tile_begin[block.id() + 1];
    for (std::int64_t first = lists.tile_begin[block.id()]; first < end; first += kBatch) {
      if (block.Count(passing.open) == 0) break;
      const int count = BatchSize(first, end, kBatch);
      StageSplats(block, lists, first, count, shared.splats);
      for (int k = 0; k < count && passing.open; ++k) {
        const Splat<S>& splat = shared.splats[k];
        const RowSpan<S> row = RowInTile(splat, pixel.y);
        const S alpha = AlphaAt(OffsetAt(static_cast<S>(pixel.x), splat.r, row.p0), row.peak);
        if (!(alpha > S(0))) continue;
        const Blend<S> blend = passing.Take(alpha);
        for (int c = 0; c < 3; ++c) color[c] = Fma(blend.weight, splat.color[c], color[c]);
      }
    }
    if (!pixel.inside) return;
    const std::int64_t plane = std::int64_t{lists.width} * lists.height;
    for (int c = 0; c < 3; ++c) {
      image[c * plane + pixel.place] = Fma(passing.transmittance, lists.background[c], color[c]);
    }
  }
};

// RasterKernels::tangent.
template <class S>
struct TangentBlock {
  static constexpr int kThreads = kRasterThreads, kBatch = kRasterThreads;
  struct Shared {
    Splat<S> splats[kBatch];
    SplatTangent<S> tangents[kBatch];
  };
  TileLists<S> lists;
  const SplatTangent<S>* tangents;
  S* d_image;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const BlockPixel pixel(lists, block.id(), block.thread());
    Passing<S> passing(pixel);
    S d_color[3] = {S(0), S(0), S(0)}, minus_dT(0);
    const std::int64_t end = lists.tile_begin[block.id() + 1];
    for (std::int64_t first = lists.tile_begin[block.id()]; first < end; first += kBatch) {
      if (block.Count(passing.open) == 0) break;
      const int count = BatchSize(first, end, kBatch);
      if (block.thread() < count) {
        shared.tangents[block.thread()] = tangents[lists.ranks[first + block.thread()]];
      }
      StageSplats(block, lists, first, count, shared.splats);
      for (int k = 0; k < count && passing.open; ++k) {
        const Splat<S>& splat = shared.splats[k];
        const RowSpan<S> row = RowInTile(splat, pixel.y);
        const S p = OffsetAt(static_cast<S>(pixel.x), splat.r, row.p0), alpha = AlphaAt(p, row.peak);
        if (!(alpha > S(0))) continue;
        const Blend<S> blend = passing.Take(alpha);
        const S* w = shared.tangents[k].w;
        const S psi =
            Psi(PsiLinear(w[kXi], w[kKappa], row.q), PsiConstant(w[kZeta], w[kSigma], w[kLambda], row.q), w[kRho], p);
        const S d_weight = TangentWeight(blend, psi, minus_dT);
        for (int c = 0; c < 3; ++c) {
          d_color[c] = TangentColor(blend, d_weight, splat.color[c], w[kColor + c], d_color[c]);
        }
      }
    }
    if (!pixel.inside) return;
    const std::int64_t plane = std::int64_t{lists.width} * lists.height;
    for (int c = 0; c < 3; ++c) d_image[c * plane + pixel.place] = Fnma(minus_dT, lists.background[c], d_color[c]);
  }
};

// What the adjoint sums along one row of a tile for a splat: g p^a for a <= 2, then w u for the colours; g is the
// derivative of the pixel's part of u . image by log alpha, w that of its colour by the splat's.
inline constexpr int kAdjointRowSums = 6;
template <class S>
struct AdjointRow {
  S sum[kAdjointRowSums] = {S(0), S(0), S(0), S(0), S(0), S(0)};

  VESTA_HD void Add(const S& g, const S& w, const S u[3], const S& p) {
    const S gp = g * p;
    sum[0] += g;
    sum[1] += gp;
    sum[2] = Fma(gp, p, sum[2]);
    for (int c = 0; c < 3; ++c) sum[3 + c] = Fma(w, u[c], sum[3 + c]);
  }
};
// Component i of the cotangent of a splat (InTile) from the sums of all rows, weighed with powers of q.
template <class S>
VESTA_HD inline S AddAdjointRows(const Splat<S>& splat, const S (&rows)[kTileSize][kAdjointRowSums], int i) {
  const int power_q = i < kSplatShape ? PowerQ(i) : 0, column = i < kSplatShape ? PowerP(i) : 3 + i - kColor;
  S sum(0);
  for (int y = 0; y < kTileSize; ++y) {
    const S q = RowInTile(splat, y).q;
    const S weight = power_q == 0 ? S(1) : power_q == 1 ? q : q * q;
    sum = Fma(weight, rows[y][column], sum);
  }
  return i < kLambda ? -sum : sum;
}

// RasterKernels::adjoint, with the sums of pair k of the lists at sums[entries[k]].
template <class S>
struct AdjointBlock {
  static constexpr int kThreads = kRasterThreads, kBatch = 16;
  struct Share {
    S g, w;  // derivative of the pixel's part of u . image by log alpha, and by u . colour
  };
  struct Shared {
    Splat<S> splats[kBatch];
    S u[3][kRasterThreads];
    Share shares[kBatch][kRasterThreads];
    S rows[kBatch][kTileSize][kAdjointRowSums];
  };
  TileLists<S> lists;
  const std::uint32_t* entries;
  const S *image, *u;
  SplatTangent<S>* sums;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const int thread = block.thread();
    const BlockPixel pixel(lists, block.id(), thread);
    const std::int64_t plane = std::int64_t{lists.width} * lists.height;
    Passing<S> passing(pixel);
    S behind(0), my_u[3];
    for (int c = 0; c < 3; ++c) {
      my_u[c] = pixel.inside ? u[c * plane + pixel.place] : S(0);
      if (pixel.inside) behind += my_u[c] * image[c * plane + pixel.place];
      shared.u[c][pixel.in_tile()] = my_u[c];
    }
    const std::int64_t end = lists.tile_begin[block.id() + 1];
    std::int64_t first = lists.tile_begin[block.id()];
    for (; first < end; first += kBatch) {
      if (block.Count(passing.open) == 0) break;
      const int count = BatchSize(first, end, kBatch);
      StageSplats(block, lists, first, count, shared.splats);
      // As pixels.
      for (int k = 0; k < count; ++k) {
        Share share = {S(0), S(0)};
        if (passing.open) {
          const Splat<S>& splat = shared.splats[k];
          const RowSpan<S> row = RowInTile(splat, pixel.y);
          const S alpha = AlphaAt(OffsetAt(static_cast<S>(pixel.x), splat.r, row.p0), row.peak);
          if (alpha > S(0)) {
            const Blend<S> blend = passing.Take(alpha);
            const S* c = splat.color;
            const S gathered = blend.weight * Fma(c[0], my_u[0], Fma(c[1], my_u[1], c[2] * my_u[2]));
            share.g = ByLogAlpha(blend, Odds(blend.alpha), gathered, behind);
            share.w = blend.weight;
          }
        }
        shared.shares[k][Column(pixel.x, pixel.y)] = share;
      }
      block.Sync();
      // As splats and rows.
      if (thread / kTileSize < count) AddRow(shared, thread / kTileSize, thread % kTileSize);
      block.Sync();
      if (thread < count * kSplatTangent) {
        const int k = thread / kSplatTangent;
        sums[entries[first + k]].w[thread % kSplatTangent] =
            AddAdjointRows(shared.splats[k], shared.rows[k], thread % kSplatTangent);
      }
    }
    // All pixels are closed.
    for (std::int64_t i = first * kSplatTangent + thread; i < end * kSplatTangent; i += kThreads) {
      sums[entries[i / kSplatTangent]].w[i % kSplatTangent] = S(0);
    }
  }

 private:
  // Place of a pixel in shares: odd rows turned by half, so that neither the pixels of half a warp, two rows of eight,
  // nor one pixel of each row fall on the same bank.
  VESTA_HD static int Column(int x, int y) { return y * kTileSize + (x + y % 2 * 8) % kTileSize; }

  VESTA_HD void AddRow(Shared& shared, int k, int y) const {
    const Splat<S>& splat = shared.splats[k];
    const RowSpan<S> row = RowInTile(splat, y);
    AdjointRow<S> total;
    for (int i = 0; i < kTileSize; ++i) {
      const int x = (i + y) % kTileSize, at = y * kTileSize + x;
      const Share& share = shared.shares[k][Column(x, y)];
      const S u_here[3] = {shared.u[0][at], shared.u[1][at], shared.u[2][at]};
      total.Add(share.g, share.w, u_here, OffsetAt(static_cast<S>(x), splat.r, row.p0));
    }
    for (int i = 0; i < kAdjointRowSums; ++i) shared.rows[k][y][i] = total.sum[i];
  }
};

// RasterKernels::gram, with the sums of pair k at sums[entries[k]].
template <class S>
struct GramBlock {
  static constexpr int kThreads = kRasterThreads, kBatch = 8;
  // Two threads a row; sums of half a row: m p^a for a <= 4, then for each colour those of the cross terms for a <= 2,
  // then the colours.
  static constexpr int kParts = 32, kHalf = kTileSize / 2, kCross = 5, kColors = kCross + 9, kPartSums = kColors + 3;
  struct alignas(16) Share {
    S w, d[3];  // derivatives of the pixel's colours by the splat's colour, and by log alpha
  };
  struct Shared {
    Splat<S> splats[kBatch];
    S omega[3][kRasterThreads];
    union {
      Share shares[kBatch][kRasterThreads];
      S parts[kBatch][kParts][kPartSums];
    };
  };
  TileLists<S> lists;
  const std::uint32_t* entries;
  const S *image, *omega;
  SplatGram<S>* sums;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const int thread = block.thread();
    const BlockPixel pixel(lists, block.id(), thread);
    const std::int64_t plane = std::int64_t{lists.width} * lists.height;
    Passing<S> passing(pixel);
    S behind[3];
    for (int c = 0; c < 3; ++c) {
      behind[c] = pixel.inside ? image[c * plane + pixel.place] : S(0);
      shared.omega[c][pixel.in_tile()] = pixel.inside ? omega[c * plane + pixel.place] : S(0);
    }
    const std::int64_t end = lists.tile_begin[block.id() + 1];
    std::int64_t first = lists.tile_begin[block.id()];
    for (; first < end; first += kBatch) {
      if (block.Count(passing.open) == 0) break;
      const int count = BatchSize(first, end, kBatch);
      StageSplats(block, lists, first, count, shared.splats);
      for (int k = 0; k < count; ++k) {
        Share share = {S(0), {S(0), S(0), S(0)}};
        if (passing.open) {
          const Splat<S>& splat = shared.splats[k];
          const RowSpan<S> row = RowInTile(splat, pixel.y);
          const S alpha = AlphaAt(OffsetAt(static_cast<S>(pixel.x), splat.r, row.p0), row.peak);
          if (alpha > S(0)) {
            const Blend<S> blend = passing.Take(alpha);
            const S odds = Odds(blend.alpha);
            share.w = blend.weight;
            for (int c = 0; c < 3; ++c) share.d[c] = ByLogAlpha(blend, odds, blend.weight * splat.color[c], behind[c]);
          }
        }
        shared.shares[k][pixel.in_tile()] = share;
      }
      block.Sync();
      S part[kPartSums];
      const int k = thread / kParts;
      if (k < count) AddHalfRow(shared, k, thread % kParts, part);
      block.Sync();  // the parts take the place of the shares
      if (k < count) {
        for (int i = 0; i < kPartSums; ++i) shared.parts[k][thread % kParts][i] = part[i];
      }
      block.Sync();
      for (int i = thread; i < count * kGramSums; i += kThreads) {
        sums[entries[first + i / kGramSums]].m[i % kGramSums] = AddParts(shared, i / kGramSums, i % kGramSums);
      }
    }
    for (std::int64_t i = first * kGramSums + thread; i < end * kGramSums; i += kThreads) {
      sums[entries[i / kGramSums]].m[i % kGramSums] = S(0);
    }
  }

 private:
  VESTA_HD void AddHalfRow(const Shared& shared, int k, int index, S part[kPartSums]) const {
    const Splat<S>& splat = shared.splats[k];
    const int y = index / 2;
    const RowSpan<S> row = RowInTile(splat, y);
    for (int i = 0; i < kPartSums; ++i) part[i] = S(0);
    for (int i = 0; i < kHalf; ++i) {
      // Each of eight neighbouring threads on a bank of its own.
      const int x = index % 2 * kHalf + (i + index) % kHalf, at = y * kTileSize + x;
      const Share& share = shared.shares[k][at];
      const S p = OffsetAt(static_cast<S>(x), splat.r, row.p0);
      S m(0);
      for (int c = 0; c < 3; ++c) {
        const S curvature = shared.omega[c][at], curvature_w = curvature * share.w;
        m = Fma(curvature * share.d[c], share.d[c], m);
        part[kColors + c] = Fma(curvature_w, share.w, part[kColors + c]);
        S cross = curvature_w * share.d[c];
        for (int a = 0; a < 3; ++a) {
          part[kCross + 3 * c + a] += cross;
          cross = cross * p;
        }
      }
      for (int a = 0; a < 5; ++a) {
        part[a] += m;
        m = m * p;
      }
    }
  }
  // Sum i of SplatGram.
  VESTA_HD S AddParts(const Shared& shared, int k, int i) const {
    // The monomial p^a q^b that it belongs to, and where the sums of its p^0 lie.
    int monomial = i, base = 0;
    if (i >= kMoments4 + 3 * kMoments2) {
      monomial = 0, base = kColors + i - kMoments4 - 3 * kMoments2;
    } else if (i >= kMoments4) {
      monomial = (i - kMoments4) % kMoments2, base = kCross + 3 * ((i - kMoments4) / kMoments2);
    }
    int degree = 0;
    while (MonomialIndex(degree + 1, 0) <= monomial) ++degree;
    const int b = monomial - MonomialIndex(degree, 0), a = degree - b;
    S sum(0);
    for (int index = 0; index < kParts; ++index) {
      const S q = RowInTile(shared.splats[k], index / 2).q;
      S weight(1);
      for (int power = 0; power < b; ++power) weight = weight * q;
      sum = Fma(weight, shared.parts[k][index][base + a], sum);
    }
    return sum;
  }
};

}  // namespace VESTA_ISA
}  // namespace vesta::splat
