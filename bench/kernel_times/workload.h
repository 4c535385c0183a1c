// SPDX-License-Identifier: Apache-2.0
// Inputs of the kernel benchmarks: a model, cameras, and photographs.
#pragma once

#include <string>
#include <vector>

#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/image/image_shape.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/splats/ply.h"

namespace vesta::bench {

struct Workload {
  std::string name;
  gs::SplatModel model;
  double extent = 1;  // as Scene::extent
  std::vector<splat::PosedCamera> views;
  std::vector<std::vector<float>> photographs;  // per view: three planes (red, green, blue)

  ImageShape shape() const { return {views.front().width, views.front().height}; }
};

// Reads a scene and its splat (.ply). All photographs must have the same size.
Workload RealWorkload(const std::string& scene, const std::string& ply);

// Round Gaussians with opacity 0.5 and SH degree 3, all inside the image and equally large there. On average `overlap`
// of them cover a pixel. The images have about `pixels` pixels, the aspect ratio 4:3 and noise as photographs. The
// camera moves slightly from view to view.
Workload SyntheticWorkload(Index gaussians, Index pixels, double overlap, int views = 1);

}  // namespace vesta::bench
