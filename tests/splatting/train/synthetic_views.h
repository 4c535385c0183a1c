// SPDX-License-Identifier: Apache-2.0
// Synthetic per-view gradients of a model with several SH degrees. Views see some of the Gaussians.
#pragma once

#include <cstdint>
#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/distributed/sum_of_views.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/random.h"

namespace vesta::gs::test {

struct SyntheticViews {
  struct View {
    std::vector<std::int32_t> rank_of;
    std::vector<splat::Splat<float>> splats;
    std::vector<splat::SplatTangent<float>> cotangents;
    std::vector<float> gradient;  // in the layout of the model
    ViewCost cost;

    density::PullView pull_view() const { return {rank_of.data(), splats.data(), cotangents.data(), 2}; }
  };
  term::Layout layout;
  std::vector<View> views;

  // attributes: number in use. gaussians: no multiple of the block size.
  explicit SyntheticViews(int count, int attributes = splat::NumAttributes(3), Index gaussians = 75) {
    std::vector<std::uint8_t> degrees;
    for (Index i = 0; i < gaussians; ++i) degrees.push_back(static_cast<std::uint8_t>(i * i % 4));
    layout = {WithDegrees(RandomModel(gaussians, 3, 5), degrees).layout(), attributes};
    vesta::test::Random random(7);
    for (int v = 0; v < count; ++v) views.push_back(Make(v, random));
  }
  Index gaussians() const { return layout.model.count; }

 private:
  // Sees no Gaussian of some blocks, and some of the others.
  View Make(int v, vesta::test::Random& random) const {
    View view;
    view.rank_of.assign(static_cast<std::size_t>(gaussians()), -1);
    view.gradient.assign(static_cast<std::size_t>(layout.model.Size()), 0);
    for (Index i = 0; i < gaussians(); ++i) {
      if ((i / term::kLanes + v) % 3 == 0 || (i + v) % 4 == 0) continue;
      view.rank_of[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(view.splats.size());
      splat::Splat<float>& splat = view.splats.emplace_back();
      splat.r = splat.s = 1, splat.beta = 0.5f;
      for (float& w : view.cotangents.emplace_back().w) w = static_cast<float>(random.Normal());
      for (int a = 0; a < layout.attributes; ++a) {
        if (i >= layout.model.Rows(a)) continue;
        view.gradient[static_cast<std::size_t>(layout.model.Offset(a) + i)] = static_cast<float>(random.Normal());
      }
    }
    view.cost = {random.Uniform(0, 1), 100.0 + v};
    return view;
  }
};

}  // namespace vesta::gs::test
