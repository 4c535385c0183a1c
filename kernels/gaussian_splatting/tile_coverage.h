// Which tiles a splat touches: those where the ellipse of its support meets the rectangle of the pixel centres.
#pragma once

#include <cmath>

#include "kernels/gaussian_splatting/types.h"
#include "kernels/math/scalar.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// The last (sign +1) or first (-1) x of the ellipse p^2 + q^2 <= support between the heights y0 and y1, given that the
// two meet. The ellipse is widest at dx = sign reach_x, dy = sign dy_at_reach; where that height is outside the strip
// its border nearest to it decides.
template <class S>
VESTA_HD inline S ExtremeX(const Splat<S>& splat, S y0, S y1, S dy_at_reach, S sign) {
  using std::sqrt;
  const S dy = Clamp(sign * dy_at_reach, y0 - splat.v, y1 - splat.v);
  const S q = splat.s * dy;
  return splat.u - splat.beta * dy + sign * sqrt(Max(splat.support - q * q, S(0))) * splat.inv_r;
}

// Calls visit(tile) for every tile the splat touches, by ascending tile.
template <class S, class Visit>
VESTA_HD inline void VisitTiles(const Splat<S>& splat, int tiles_x, int tiles_y, int width, int height,
                                const Visit& visit) {
  using std::sqrt;
  constexpr S kSize(kTileSize), kHalf(0.5);
  const S reach_y = sqrt(splat.support) / splat.s;
  const S slope = splat.beta / splat.s;
  const S reach_x = sqrt(splat.support * (splat.inv_r * splat.inv_r + slope * slope));
  // dx = p / r - beta q / s is largest at q = -slope / |(1 / r, slope)| sqrt(support).
  const S dy_at_reach = -slope * splat.support / (splat.s * reach_x);
  const auto clip = [](S value, int limit) { return static_cast<int>(Clamp(value, S(0), static_cast<S>(limit))); };
  // Tile t holds pixel centres 16 t + 0.5 .. 16 t + 15.5.
  const int row0 = clip((splat.v - reach_y - kHalf) / kSize, tiles_y - 1);
  const int row1 = clip((splat.v + reach_y - kHalf) / kSize, tiles_y - 1);
  for (int row = row0; row <= row1; ++row) {
    const S y0 = Max(static_cast<S>(row) * kSize + kHalf, splat.v - reach_y);
    const S y1 = Min(static_cast<S>(Min((row + 1) * kTileSize, height)) - kHalf, splat.v + reach_y);
    if (y0 > y1) continue;
    const S right = ExtremeX(splat, y0, y1, dy_at_reach, S(1));
    const S left = ExtremeX(splat, y0, y1, dy_at_reach, S(-1));
    if (right < kHalf || left > static_cast<S>(width) - kHalf) continue;
    const int last = clip((right - kHalf) / kSize, tiles_x - 1);
    for (int column = clip((left - kHalf) / kSize, tiles_x - 1); column <= last; ++column) {
      const S last_centre = static_cast<S>((column + 1) * kTileSize) - kHalf;
      if (last_centre < left) continue;  // the support begins in the gap between two tiles' pixel centres
      visit(row * tiles_x + column);
    }
  }
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
