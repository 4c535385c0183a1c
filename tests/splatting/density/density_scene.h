// SPDX-License-Identifier: Apache-2.0
// A model in front of one camera, and density control with given pulls.
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
  static constexpr float kScale = 2;  // as for images of half size
  Scene scene = RingOfCameras(1, 64, 48, false);
  SplatModel model;
  splat::SplatView<float> view;
  splat::ViewWorkspace<float> workspace;
  std::vector<splat::SplatTangent<float>> cotangents;  // by rank, of the last view observed

  explicit DensityScene(Index count, std::uint64_t seed = 1) : model(RandomModel(count, 1, seed)) {}

  // pulls[i]: pull of Gaussian i, up to rounding; 0 is exact. Equal parts of it are along p and q.
  void Observe(DensityControl<Host>& control, const std::vector<float>& pulls) {
    view.Build(ToKernelModel(model), ToPosedCamera(scene.views[0], 0.01), std::array<double, 3>{}.data(), workspace);
    cotangents.assign(static_cast<std::size_t>(view.num_splats()), {});
    for (Index i = 0; i < model.count; ++i) {
      const std::int32_t rank = view.rank_of()[i];
      ASSERT_GE(rank, 0) << "Gaussian " << i << " is not visible";
      const splat::Splat<float>& splat = view.splats()[rank];
      const float part =
          std::sqrt(0.5f) * pulls[static_cast<std::size_t>(i)] / (kScale * static_cast<float>(splat::kTwoLn2));
      float* w = cotangents[static_cast<std::size_t>(rank)].w;
      w[splat::kPullP] = part / (splat.r * std::sqrt(1 + splat.beta * splat.beta));
      w[splat::kPullQ] = part / splat.s;
    }
    control.Observe({view.rank_of().data(), view.splats().data(), cotangents.data(), kScale});
  }
};

inline double OpacityOf(const SplatModel& model, Index i) {
  return 1 / (1 + std::exp(-double{model.attribute(splat::kOpacity)[i]}));
}

}  // namespace vesta::gs::test
