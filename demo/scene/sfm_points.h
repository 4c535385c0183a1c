// SPDX-License-Identifier: Apache-2.0
// A point cloud as from structure from motion: surface points with errors.
#pragma once

#include <cstdint>
#include <vector>

#include "demo/scene/trace.h"

namespace vesta::demo {

struct SurfacePoint {
  Vec3 position;
  std::uint8_t color[3] = {0, 0, 0};
};

// Standard deviation of a point's position along each axis, relative to its distance from the camera.
inline constexpr double kPointNoise = 0.003;

// Samples `count` points. Each is the surface point at the centre of a random pixel of a random view, moved by Gaussian
// noise along each axis, and has the colour of the pixel. images[k] is the image of views[k].
std::vector<SurfacePoint> SampleSurface(const Scene& scene, const std::vector<View>& views,
                                        const std::vector<gs::Image>& images, int count, std::uint64_t seed);

}  // namespace vesta::demo
