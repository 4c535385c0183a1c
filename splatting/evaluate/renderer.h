// SPDX-License-Identifier: Apache-2.0
// Views of models on the host, and their quality.
#pragma once

#include <array>

#include "kernels/gaussian_splatting/view/splat_view.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/evaluate/evaluation.h"
#include "splatting/evaluate/quality.h"

namespace vesta::gs {

// A rendered image as it is compared with its photograph: pixels that do not count show what that shows.
Image ToCompare(Image rendered, const Image& photograph);

// Renders views of models; keeps its working memory between calls.
class Renderer {
 public:
  // background: 0..1. near: distance of the near plane, world units.
  Renderer(const std::array<double, 3>& background, double near) : background_(background), near_(near) {}

  // The model seen from the view, not clamped.
  Image Render(const SplatModel& model, const View& view);
  Evaluation Evaluate(const SplatModel& model, const Scene& scene);
  // The same for a model still in training, with fewer active SH bands.
  Evaluation Evaluate(const splat::Model<float>& model, const Scene& scene, const MeasuredViews& measured = {});

 private:
  std::array<double, 3> background_;
  double near_;
  splat::SplatView<float> splats_;
  splat::ViewWorkspace<float> workspace_;
};

}  // namespace vesta::gs
