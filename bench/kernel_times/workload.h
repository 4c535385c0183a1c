// SPDX-License-Identifier: Apache-2.0
// What the kernels are timed on: a model, views of it, and the photographs they are compared with.
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
  double extent = 1;  // of the scene
  std::vector<splat::PosedCamera> views;
  std::vector<std::vector<float>> photographs;  // of each view, planar

  ImageShape shape() const { return {views.front().width, views.front().height}; }
};

// A scene on disk and a model of it.
Workload RealWorkload(const std::string& scene, const std::string& ply);

// Round Gaussians of one size before one camera, all in the image and of opacity 0.5, such that `overlap` of them count
// at a pixel if none is hidden; 4:3 images of noise. SH degree 3. The camera moves a little from view to view.
Workload MadeUpWorkload(Index gaussians, Index pixels, double overlap, int views = 1);

}  // namespace vesta::bench
