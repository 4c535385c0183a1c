// SPDX-License-Identifier: Apache-2.0
// Ray tracing of the scene.
#pragma once

#include <cstdint>

#include "demo/scene/scene.h"
#include "problems/gaussian_splatting/scene/distortion.h"
#include "splatting/io/images/image_file.h"

namespace vesta::demo {

// A camera with its pose. Pixel (i, j) has its centre at (i + 0.5, j + 0.5). A world point p has the camera coordinates
// Rotate(cam_from_world, p - position): x right, y down, z forward.
struct View {
  int width = 0, height = 0;
  double focal = 0;  // pixels; the principal point is the image centre
  Frame cam_from_world;
  Vec3 position;             // in the world
  gs::Distortion lens = {};  // must be invertible on the image
};

// Unit vector, in world coordinates, of the ray through image position (u, v), in pixels. Throws Error if the
// distortion is not invertible there.
Vec3 RayDirection(const View& view, double u, double v);

// A pixel is the mean of 16 rays, one through each cell of a 4 x 4 grid on the pixel. Each ray uses one random point of
// the lamp for light and shadow, each in another cell of a 4 x 4 grid on the lamp. `seed` determines the random
// numbers. The image does not depend on the number of threads.
gs::Image Render(const Scene& scene, const View& view, std::uint64_t seed);

}  // namespace vesta::demo
