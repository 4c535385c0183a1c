// SPDX-License-Identifier: Apache-2.0
// The pixels that a splat covers in each row of a tile, and the values of the splat that are constant along a row. One
// template serves the CPU's two traversals and the GPU's passes. Compiled for the CPU, all three compute the same bits:
//
//   traverse_splats.h   the SIMD lanes are 16 rows of one splat
//   traverse_rows.h     the SIMD lanes are 16 splats in one row
//   tile_block.h        scalars: a GPU thread computes the row of its pixel, for one splat at a time
#pragma once

#include <cmath>

#include "kernels/gaussian_splatting/formulas/pixel_steps.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// Centre of a tile's first pixel.
template <class S>
struct TileOrigin {
  S left, top;

  VESTA_HD TileOrigin(const TileLists<S>& lists, int tile) : TileOrigin(tile % lists.tiles_x, tile / lists.tiles_x) {}
  VESTA_HD TileOrigin(int column, int row)
      : left(static_cast<S>(column * kTileSize) + S(0.5)), top(static_cast<S>(row * kTileSize) + S(0.5)) {}
};

// Returns the splat with its mean relative to the tile's origin.
template <class S>
VESTA_HD inline Splat<S> InTile(const Splat<S>& splat, const TileOrigin<S>& origin) {
  Splat<S> moved = splat;
  moved.u = splat.u - origin.left;
  moved.v = splat.v - origin.top;
  return moved;
}

// The members of a splat from InTile that RowPosition and RowSpan need. V: a scalar or a SIMD vector, whose lanes
// contain the same splat or different ones.
template <class V>
struct RowSplat {
  V u, v, r, s, beta, log2_opacity, support, inv_r;
};
template <class V, class S>
VESTA_HD inline RowSplat<V> InAllLanes(const Splat<S>& splat) {
  return {V(splat.u),       V(splat.v),    V(splat.r), V(splat.s), V(splat.beta), V(splat.log2_opacity),
          V(splat.support), V(splat.inv_r)};
}

// A row in the whitened coordinates (p, q) of a splat (types.h): pixel x of the tile is at (p0 + r x, q).
template <class V>
struct RowPosition {
  V q;
  V p0;
  V middle;  // x where p is 0

  // y: row of the tile, for each lane.
  VESTA_HD RowPosition(const RowSplat<V>& splat, const V& y) {
    const V dy = y - splat.v;
    q = splat.s * dy;
    middle = Fnma(splat.beta, dy, splat.u);
    p0 = Fnma(middle, splat.r, V(0));
  }
};

// Pixels [begin, end) of a row.
struct PixelRange {
  int begin, end;
};

// The covered pixels of a row: begin <= x <= end if `reaches` is true, else none. A pixel is covered if p^2 + q^2 is at
// most Splat::support. Only at covered pixels can alpha reach 1/255.
template <class V>
struct RowSpan : RowPosition<V> {
  using L = Lanes<V>;
  using S = typename L::Scalar;
  V peak;  // log2 of the opacity, minus q^2
  V begin, end;
  typename L::Mask reaches;

  VESTA_HD RowSpan(const RowSplat<V>& splat, const V& y)
      : RowPosition<V>(splat, y), peak(Fnma(this->q, this->q, splat.log2_opacity)) {
    using std::ceil;
    const V rest = Fnma(this->q, this->q, splat.support);
    reaches = rest > V(0);
    // Splat::support is enlarged by more than the rounding error of the root, so no pixel is lost.
    const V half_width = MaskedSquareRoot(reaches, rest) * splat.inv_r;
    begin = ceil(this->middle - half_width);
    end = this->middle + half_width;
  }

  // Only for scalars: the covered pixels of the row among first .. last.
  VESTA_HD PixelRange PixelsIn(int first, int last) const {
    if (!reaches) return {first, first};
    return {static_cast<int>(Clamp(begin, S(first), S(last + 1))),
            static_cast<int>(Clamp(end, S(first - 1), S(last))) + 1};
  }

  // Returns one bit per lane: 1 if the lane's row has a covered pixel in vector k, the pixels from k * kWidth to
  // (k + 1) * kWidth - 1. A span between two neighbouring pixel centres covers no pixel, so its bit is 0.
  VESTA_HD std::uint32_t TouchesVector(int k) const {
    const V from(static_cast<S>(k * L::kWidth)), to(static_cast<S>(k * L::kWidth + L::kWidth - 1));
    return L::Bits(reaches & (Max(begin, from) <= Min(end, to)));
  }
};

// Unused members are optimised away.
template <class S>
VESTA_HD inline RowSpan<S> RowInTile(const Splat<S>& splat, int y) {
  return RowSpan<S>(InAllLanes<S>(splat), static_cast<S>(y));
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
