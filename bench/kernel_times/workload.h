// SPDX-License-Identifier: Apache-2.0
// Workloads of the kernel benchmarks: a model, views of it, and photographs.
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
  double extent = 1;  // scene extent
  std::vector<splat::PosedCamera> views;
  std::vector<std::vector<float>> photographs;  // one per view, planar RGB

  ImageShape shape() const { return {views.front().width, views.front().height}; }
};

// Reads a scene and a model of it from disk. All images must have the same size.
Workload RealWorkload(const std::string& scene, const std::string& ply);

// Synthetic workload: isotropic Gaussians of equal image size and opacity 0.5, all inside the image. Their size makes
// `overlap` of them cover each pixel if occlusion is ignored. SH degree 3; 4:3 images of noise; the camera moves
// slightly from view to view.
Workload SyntheticWorkload(Index gaussians, Index pixels, double overlap, int views = 1);

}  // namespace vesta::bench
