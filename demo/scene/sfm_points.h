// SPDX-License-Identifier: Apache-2.0
// The kind of point cloud that structure from motion leaves: surface points with some error.
#pragma once

#include <cstdint>
#include <vector>

#include "demo/scene/trace.h"

namespace vesta::demo {

struct SurfacePoint {
  Vec3 position;
  std::uint8_t color[3] = {0, 0, 0};
};

// Error of a point's position along each axis, as a share of its distance from the camera (standard deviation).
inline constexpr double kPointNoise = 0.003;

// `count` points, each the surface seen at the centre of a random pixel of a random view, moved by normal noise, with
// that pixel's colour. images[k] is what views[k] takes.
std::vector<SurfacePoint> SampleSurface(const Scene& scene, const std::vector<View>& views,
                                        const std::vector<gs::Image>& images, int count, std::uint64_t seed);

}  // namespace vesta::demo
