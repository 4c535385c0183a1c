// SPDX-License-Identifier: Apache-2.0
// Pictures of the scene.
#pragma once

#include <cstdint>

#include "demo/scene/scene.h"
#include "problems/gaussian_splatting/scene/distortion.h"
#include "splatting/io/images/image_file.h"

namespace vesta::demo {

// A camera: a pinhole, and a lens that bends what it shows. Pixel (i, j) has its centre at (i + 0.5, j + 0.5); a point
// p lies at z > 0 in Rotate(cam_from_world, p - position), whose x axis points right and y axis down.
struct View {
  int width = 0, height = 0;
  double focal = 0;  // pixels; the principal point is the image's centre
  Frame cam_from_world;
  Vec3 position;
  gs::Distortion lens = {};  // one to one on the image
};

// Unit direction, in the world, of the ray through image position (u, v), in pixels. Throws Error where the lens shows
// nothing there.
Vec3 RayDirection(const View& view, double u, double v);

// The picture that the view takes. Each pixel averages 16 rays, one in each cell of a 4 x 4 grid, and each ray sees one
// point of the lamp, one in each cell of another such grid. The noise depends on `seed`, the picture not on the number
// of threads.
gs::Image Render(const Scene& scene, const View& view, std::uint64_t seed);

}  // namespace vesta::demo
