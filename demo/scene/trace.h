// SPDX-License-Identifier: Apache-2.0
// Renders images of the scene by ray tracing.
#pragma once

#include <cstdint>

#include "demo/scene/scene.h"
#include "problems/gaussian_splatting/scene/distortion.h"
#include "splatting/io/images/image_file.h"

namespace vesta::demo {

// A pinhole camera with lens distortion. Pixel (i, j) has its centre at (i + 0.5, j + 0.5). Camera coordinates are
// Rotate(cam_from_world, p - position): x points right, y down, and z > 0 in front of the camera.
struct View {
  int width = 0, height = 0;
  double focal = 0;  // pixels; the principal point is the centre of the image
  Frame cam_from_world;
  Vec3 position;
  gs::Distortion lens = {};  // must be invertible on the image
};

// Unit direction in the world of the ray through image position (u, v), in pixels. Throws Error if the distortion is
// not invertible there.
Vec3 RayDirection(const View& view, double u, double v);

// Renders the image of a view. Each pixel averages 16 rays, one in each cell of a 4 x 4 grid. Each ray samples one
// point of the lamp, in a different cell of another such grid. The noise depends on `seed`; the image does not depend
// on the number of threads.
gs::Image Render(const Scene& scene, const View& view, std::uint64_t seed);

}  // namespace vesta::demo
