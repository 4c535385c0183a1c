// SPDX-License-Identifier: Apache-2.0
// The pixels of one tile: position in the image, transmittance, and copies to and from planes.
#pragma once

#include <cstdint>

#include "kernels/gaussian_splatting/formulas/pixel_steps.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

inline constexpr int kTilePixels = kTileSize * kTileSize;

// Position of a tile in the image.
struct TileWindow {
  int x0, y0;         // first pixel
  int width, height;  // pixels inside the image, 1..16 each
};

template <class S>
inline TileWindow WindowOf(const TileLists<S>& lists, int tile) {
  const int x0 = tile % lists.tiles_x * kTileSize, y0 = tile / lists.tiles_x * kTileSize;
  const int w = lists.width - x0, h = lists.height - y0;
  return {x0, y0, w < kTileSize ? w : kTileSize, h < kTileSize ? h : kTileSize};
}

// Blending state of a tile's pixels, updated splat by splat, front to back. The transmittance of a pixel is the
// fraction of the light from behind that the splats so far let through. A splat that would reduce it to less than 1e-4
// closes the pixel; no further splat is then blended (BlendSplat).
template <class V, class S>
struct TilePixels {
  using L = Lanes<V>;
  static constexpr int kVectors = kTileSize / L::kWidth;  // per row

  alignas(64) S transmittance[kTilePixels];  // 0 if the pixel is closed or outside the image
  std::uint32_t open[kVectors] = {};         // bit y of open[k]: vector k of row y has an open pixel

  TilePixels(const TileLists<S>& lists, int tile) {
    const TileWindow window = WindowOf(lists, tile);
    const V iota = L::Iota(), width(static_cast<S>(window.width));
    for (int y = 0; y < kTileSize; ++y) {
      for (int k = 0; k < kVectors; ++k) {
        const int x = k * L::kWidth;
        const bool inside = y < window.height && x < window.width;
        L::Store(transmittance + y * kTileSize + x,
                 inside ? Select(iota + V(static_cast<S>(x)) < width, V(1), V(0)) : V(0));
        if (inside) open[k] |= 1U << y;
      }
    }
  }

  std::uint32_t open_rows() const {
    std::uint32_t any = 0;
    for (const std::uint32_t rows : open) any |= rows;
    return any;
  }
  void CloseRow(int row, int k) { open[k] &= ~(1U << row); }
};

template <class V, class S>
inline void SetZero(S* tile) {
  for (int i = 0; i < kTilePixels; i += Lanes<V>::kWidth) Lanes<V>::Store(tile + i, V(0));
}

// Copies the tile's window of one plane of a planar image to `tile`, 16 rows of 16 pixels. Pixels outside the image
// become zero.
template <class V, class S>
inline void LoadPlane(const TileLists<S>& lists, const TileWindow& window, const S* plane, S* tile) {
  for (int y = 0; y < kTileSize; ++y) {
    const S* row = plane + static_cast<std::int64_t>(window.y0 + y) * lists.width + window.x0;
    S* to = tile + y * kTileSize;
    if (y < window.height && window.width == kTileSize) {
      for (int x = 0; x < kTileSize; x += Lanes<V>::kWidth) Lanes<V>::Store(to + x, Lanes<V>::Load(row + x));
    } else {
      for (int x = 0; x < kTileSize; ++x) to[x] = y < window.height && x < window.width ? row[x] : S(0);
    }
  }
}
// Prefetches the cache lines that StorePlane will write, before the tile is processed.
template <class S>
inline void PrefetchPlane(const TileLists<S>& lists, const TileWindow& window, const S* plane) {
  for (int y = 0; y < window.height; ++y) {
    const S* row = plane + static_cast<std::int64_t>(window.y0 + y) * lists.width + window.x0;
    __builtin_prefetch(row, 1);
    __builtin_prefetch(row + window.width - 1, 1);
  }
}
// Copies the pixels inside the image back to the plane.
template <class V, class S>
inline void StorePlane(const TileLists<S>& lists, const TileWindow& window, const S* tile, S* plane) {
  for (int y = 0; y < window.height; ++y) {
    S* row = plane + static_cast<std::int64_t>(window.y0 + y) * lists.width + window.x0;
    const S* from = tile + y * kTileSize;
    if (window.width == kTileSize) {
      for (int x = 0; x < kTileSize; x += Lanes<V>::kWidth) Lanes<V>::Store(row + x, Lanes<V>::Load(from + x));
    } else {
      for (int x = 0; x < window.width; ++x) row[x] = from[x];
    }
  }
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
