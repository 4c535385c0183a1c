// SPDX-License-Identifier: Apache-2.0
// The tiles that a splat touches. A splat touches a tile if the ellipse of its support (types.h) intersects the
// rectangle of the tile's pixel centres.
#pragma once

#include <cmath>

#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/math/scalar.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// The extent of a splat's support, the ellipse p^2 + q^2 <= support.
template <class S>
struct SupportReach {
  S y;            // vertical distance from the mean to the highest and lowest points
  S dy_at_right;  // y of the rightmost point minus y of the mean; the leftmost point has the opposite sign

  VESTA_HD explicit SupportReach(const Splat<S>& splat) {
    using std::sqrt;
    y = sqrt(splat.support) / splat.s;
    const S slope = splat.beta / splat.s;
    const S x = sqrt(splat.support * (splat.inv_r * splat.inv_r + slope * slope));
    // dx = p / r - beta q / s is largest at q = -slope / |(1 / r, slope)| sqrt(support).
    dy_at_right = -slope * splat.support / (splat.s * x);
  }
};

// The largest (sign = 1) or smallest (sign = -1) x of the ellipse in the strip between the heights y0 and y1, which the
// ellipse must reach. The largest x is at the ellipse's rightmost point, or at the nearest border of the strip if this
// point is outside.
template <class S>
VESTA_HD inline S ExtremeX(const Splat<S>& splat, const SupportReach<S>& reach, S y0, S y1, S sign) {
  using std::sqrt;
  const S dy = Clamp(sign * reach.dy_at_right, y0 - splat.v, y1 - splat.v);
  const S q = splat.s * dy;
  return splat.u - splat.beta * dy + sign * sqrt(Max(splat.support - q * q, S(0))) * splat.inv_r;
}

// Iterates, row by row, over the tiles that a splat touches.
template <class S>
struct TileRows {
  Splat<S> splat;
  SupportReach<S> reach;
  int tiles_x, width, height;
  int begin, end;  // rows of tiles that it may touch: begin .. end - 1

  VESTA_HD TileRows(const Splat<S>& of, int columns, int rows, int image_width, int image_height)
      : splat(of), reach(of), tiles_x(columns), width(image_width), height(image_height) {
    // Tile t has the pixel centres 16 t + 0.5 .. 16 t + 15.5.
    begin = Clip((splat.v - reach.y - S(0.5)) / S(kTileSize), rows - 1);
    end = Clip((splat.v + reach.y - S(0.5)) / S(kTileSize), rows - 1) + 1;
  }

  // Computes the touched tiles *first .. *last in a row of tiles. Returns false if the splat touches no tile of the
  // row.
  VESTA_HD bool Row(int row, int* first, int* last) const {
    constexpr S kSize(kTileSize), kHalf(0.5);
    const S y0 = Max(static_cast<S>(row) * kSize + kHalf, splat.v - reach.y);
    const S y1 = Min(static_cast<S>(Min((row + 1) * kTileSize, height)) - kHalf, splat.v + reach.y);
    if (y0 > y1) return false;
    const S right = ExtremeX(splat, reach, y0, y1, S(1));
    const S left = ExtremeX(splat, reach, y0, y1, S(-1));
    if (right < kHalf || left > static_cast<S>(width) - kHalf) return false;
    *last = Clip((right - kHalf) / kSize, tiles_x - 1);
    *first = Clip((left - kHalf) / kSize, tiles_x - 1);
    // The support may begin in the gap between the pixel centres of two tiles.
    while (*first <= *last && static_cast<S>((*first + 1) * kTileSize) - kHalf < left) ++*first;
    return *first <= *last;
  }
  VESTA_HD int CountIn(int row) const {
    int first = 0, last = 0;
    return Row(row, &first, &last) ? last - first + 1 : 0;
  }

 private:
  VESTA_HD static int Clip(S value, int limit) { return static_cast<int>(Clamp(value, S(0), static_cast<S>(limit))); }
};

// Calls visit(tile) for every tile that the splat touches, in ascending order.
template <class S, class Visit>
VESTA_HD inline void VisitTiles(const Splat<S>& splat, int tiles_x, int tiles_y, int width, int height,
                                const Visit& visit) {
  const TileRows<S> rows(splat, tiles_x, tiles_y, width, height);
  int first = 0, last = 0;
  for (int row = rows.begin; row < rows.end; ++row) {
    if (!rows.Row(row, &first, &last)) continue;
    for (int column = first; column <= last; ++column) visit(row * tiles_x + column);
  }
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
