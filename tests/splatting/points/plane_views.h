// SPDX-License-Identifier: Apache-2.0
// Views of a textured plane.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "kernels/core/random.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs::test {

constexpr int kPlaneWidth = 120, kPlaneHeight = 90;  // of the images, pixels

// Smooth noise on the plane, 0..1: values at the corners of cells of side 0.15, interpolated.
inline float Texture(double x, double y, int channel) {
  const auto corner = [&](double i, double j) {
    CounterRandom random(static_cast<std::uint64_t>(channel), static_cast<std::uint64_t>(i + 1e6),
                         static_cast<std::uint64_t>(j + 1e6));
    return random.Uniform();
  };
  const double u = x / 0.15, v = y / 0.15, i = std::floor(u), j = std::floor(v);
  const double a = u - i, b = v - j;
  return static_cast<float>(
      std::lerp(std::lerp(corner(i, j), corner(i + 1, j), a), std::lerp(corner(i, j + 1), corner(i + 1, j + 1), a), b));
}

// The plane z = 4 + slope x.
struct Plane {
  double slope = 0;
  double Height(double x) const { return 4 + slope * x; }
};

using Painting = std::function<float(double x, double y, int channel)>;

// Cameras side by side that look along z at a painted plane.
inline std::vector<View> ViewsOf(const Plane& plane, int count, const Painting& painting) {
  std::vector<View> views(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    View& view = views[static_cast<std::size_t>(k)];
    const double x = 0.4 * k;
    view.camera = {.width = kPlaneWidth, .height = kPlaneHeight, .lens = {.fx = 100, .fy = 100, .cx = 60, .cy = 45}};
    view.translation = {-x, 0, 0};
    view.image = Image(kPlaneWidth, kPlaneHeight);
    for (int j = 0; j < kPlaneHeight; ++j) {
      for (int i = 0; i < kPlaneWidth; ++i) {
        const double a = (i + 0.5 - 60) / 100, b = (j + 0.5 - 45) / 100;
        const double depth = plane.Height(x) / (1 - plane.slope * a);
        for (int c = 0; c < 3; ++c) view.image.plane(c)[j * kPlaneWidth + i] = painting(x + a * depth, b * depth, c);
      }
    }
  }
  return views;
}

inline std::vector<View> TexturedViews(const Plane& plane, int count) { return ViewsOf(plane, count, Texture); }

}  // namespace vesta::gs::test
