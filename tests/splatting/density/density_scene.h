// SPDX-License-Identifier: Apache-2.0
// A model in front of one camera, and density control with given screen-space gradients.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/density/density.h"
#include "splatting/evaluate/evaluation.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/splatting/adam/model_adam.h"

namespace vesta::gs::test {

struct DensityScene {
  static constexpr double kLossScale = 100;
  Scene scene = RingOfCameras(1, 64, 48, false);
  SplatModel model;
  splat::SplatView<float> view;
  splat::ViewWorkspace<float> workspace;
  std::vector<splat::SplatTangent<float>> cotangents;  // by rank, of the last view observed

  explicit DensityScene(Index count, std::uint64_t seed = 1) : model(RandomModel(count, 1, seed)) {}

  // grad2d[i]: gradient of Gaussian i along the image rows, in normalised device coordinates.
  void Observe(DensityControl<Host>& control, const std::vector<float>& grad2d) {
    view.Build(ToKernelModel(model), ToPosedCamera(scene.views[0], 0.01), std::array<double, 3>{}.data(), workspace);
    cotangents.assign(static_cast<std::size_t>(view.num_splats()), {});
    for (Index i = 0; i < model.count; ++i) {
      const std::int32_t rank = view.rank_of()[i];
      ASSERT_GE(rank, 0) << "Gaussian " << i << " is not visible";
      const splat::Splat<float>& splat = view.splats()[rank];
      const float by_u = static_cast<float>(kLossScale / 32) * grad2d[static_cast<std::size_t>(i)];
      float* w = cotangents[static_cast<std::size_t>(rank)].w;
      w[splat::kXi] = -by_u / (static_cast<float>(splat::kTwoLn2) * splat.r);
      w[splat::kZeta] = splat.beta * by_u / (static_cast<float>(splat::kTwoLn2) * splat.s);
    }
    control.Observe(density::Grad2dOf(view, cotangents.data(), kLossScale));
  }
};

inline double OpacityOf(const SplatModel& model, Index i) {
  return 1 / (1 + std::exp(-double{model.attribute(splat::kOpacity)[i]}));
}

}  // namespace vesta::gs::test
