// SPDX-License-Identifier: Apache-2.0
// Simulates the point cloud of structure from motion: points on the surfaces, with errors.
#pragma once

#include <cstdint>
#include <vector>

#include "demo/scene/trace.h"

namespace vesta::demo {

struct SurfacePoint {
  Vec3 position;
  std::uint8_t color[3] = {0, 0, 0};  // red, green, blue
};

// Standard deviation of the error along each axis, relative to the distance from the camera.
inline constexpr double kPointNoise = 0.003;

// Samples `count` points: the surface point at the centre of a random pixel of a random view, plus Gaussian noise along
// each axis, with the pixel's colour. images[k] is the image of views[k]. `seed` determines the random numbers.
std::vector<SurfacePoint> SampleSurface(const Scene& scene, const std::vector<View>& views,
                                        const std::vector<gs::Image>& images, int count, std::uint64_t seed);

}  // namespace vesta::demo
