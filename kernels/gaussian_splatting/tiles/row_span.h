// SPDX-License-Identifier: Apache-2.0
// Where splats reach in rows of a tile, and what stays the same along a row. One template for both orders of work: the
// lanes are 16 rows of one splat (traverse_splats.h) or 16 splats in one row (traverse_rows.h), with the same bits; on
// a device one row of one splat (tile_block.h).
#pragma once

#include <cmath>

#include "kernels/gaussian_splatting/formulas/pixel_steps.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// The centre of a tile's first pixel.
template <class S>
struct TileOrigin {
  S left, top;

  VESTA_HD TileOrigin(const TileLists<S>& lists, int tile) : TileOrigin(tile % lists.tiles_x, tile / lists.tiles_x) {}
  VESTA_HD TileOrigin(int column, int row)
      : left(static_cast<S>(column * kTileSize) + S(0.5)), top(static_cast<S>(row * kTileSize) + S(0.5)) {}
};

// A splat with its mean relative to the tile's origin.
template <class S>
VESTA_HD inline Splat<S> InTile(const Splat<S>& splat, const TileOrigin<S>& origin) {
  Splat<S> moved = splat;
  moved.u = splat.u - origin.left;
  moved.v = splat.v - origin.top;
  return moved;
}

// The members of a splat of InTile that the rows need, one splat in all lanes or one in each.
template <class V>
struct RowSplat {
  V u, v, r, s, beta, log2_opacity, support, inv_r;
};
template <class V, class S>
VESTA_HD inline RowSplat<V> InAllLanes(const Splat<S>& splat) {
  return {V(splat.u),       V(splat.v),    V(splat.r), V(splat.s), V(splat.beta), V(splat.log2_opacity),
          V(splat.support), V(splat.inv_r)};
}

// The place of a row in a splat's whitened coordinates: pixel x is at (p0 + r x, q).
template <class V>
struct RowPlace {
  V q;
  V p0;
  V middle;  // x where p is 0

  // y: rows of the tile.
  VESTA_HD RowPlace(const RowSplat<V>& splat, const V& y) {
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

template <class V>
struct RowSpan : RowPlace<V> {
  using L = Lanes<V>;
  using S = typename L::Scalar;
  V peak;  // log2 of the opacity, less q^2
  V begin, end;
  typename L::Mask reaches;

  VESTA_HD RowSpan(const RowSplat<V>& splat, const V& y)
      : RowPlace<V>(splat, y), peak(Fnma(this->q, this->q, splat.log2_opacity)) {
    using std::ceil;
    const V rest = Fnma(this->q, this->q, splat.support);
    reaches = rest > V(0);
    // The support's margin is larger than this root's error.
    const V half_width = MaskedSquareRoot(reaches, rest) * splat.inv_r;
    begin = ceil(this->middle - half_width);
    end = this->middle + half_width;
  }

  // Of one row: its pixels within reach, of those from first to last.
  VESTA_HD PixelRange PixelsIn(int first, int last) const {
    if (!reaches) return {first, first};
    return {static_cast<int>(Clamp(begin, S(first), S(last + 1))),
            static_cast<int>(Clamp(end, S(first - 1), S(last))) + 1};
  }

  // Lane by lane: whether vector k of the row holds a pixel within reach; not where the span lies between two.
  VESTA_HD std::uint32_t Meets(int k) const {
    const V from(static_cast<S>(k * L::kWidth)), to(static_cast<S>(k * L::kWidth + L::kWidth - 1));
    return L::Bits(reaches & (Max(begin, from) <= Min(end, to)));
  }
};

// A splat of InTile on row y of the tile. What is not used of it costs nothing.
template <class S>
VESTA_HD inline RowSpan<S> RowInTile(const Splat<S>& splat, int y) {
  return RowSpan<S>(InAllLanes<S>(splat), static_cast<S>(y));
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
