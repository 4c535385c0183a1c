// SPDX-License-Identifier: Apache-2.0
// Predictions of loss_passes.h for a recoloured splat agree with the recoloured image's loss.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernels/math/spherical_harmonics.h"
#include "tests/kernels/gaussian_splatting/linearized_scene.h"

namespace vesta::splat {
namespace {

using test::Open;
using test::Scene;
using test::TruthOf;

constexpr double kSteps[kRecolors] = {-0.2, 0.05, 0.3};

// One Gaussian with all channels increased by `step`.
Scene Recolored(Scene scene, int gaussian, double step) {
  for (int c = 0; c < 3; ++c) scene.At(kSh + c, gaussian) += step / sh::k0;
  return scene;
}

// Per Gaussian, for the colour changes kSteps, with all colours above 0.
template <class S>
std::vector<RecolorRises<double>> MakeForecast(test::LinearizedScene<S>& linearized, int count) {
  std::vector<RecolorRises<double>> rises(static_cast<std::size_t>(count));
  const SplatView<S>& view = linearized.rendered.view;
  const auto recolor = [&](Index i) {
    Recolors<S> to;
    for (int d = 0; d < kRecolors; ++d) {
      for (int c = 0; c < 3; ++c) {
        to.color[d][c] = view.splats()[view.rank_of()[i]].color[c] + static_cast<S>(kSteps[d]);
      }
    }
    return to;
  };
  view.AddRecolorRises(linearized.loss(), recolor, rises.data(), linearized.rendered.workspace);
  return rises;
}

Scene Bright(int count, std::uint64_t seed) {
  Scene scene = test::RandomScene(Open(count), seed);
  for (int c = 0; c < 3; ++c) {
    for (int i = 0; i < count; ++i) scene.At(kSh + c, i) += 2;
  }
  return scene;
}

TEST(Recolor, IsExactForALossWithoutSsim) {
  const Scene scene = Bright(7, 3);
  const std::vector<double> truth = TruthOf(scene);
  for (const auto pixel : {PixelLinearization::kIrls, PixelLinearization::kL2}) {
    const PhotometricWeights weights{.l1 = 1, .ssim = 0, .pixel = pixel};
    test::LinearizedScene<double> linearized(scene, truth, weights);
    const auto rises = MakeForecast(linearized, scene.count);
    for (int i = 0; i < scene.count; ++i) {
      for (int d = 0; d < kRecolors; ++d) {
        const double rise = test::CostOf(Recolored(scene, i, kSteps[d]), truth, weights) - linearized.cost;
        EXPECT_NEAR(rises[static_cast<std::size_t>(i)].rise[d], rise, 1e-10 * linearized.cost) << i << " " << d;
      }
    }
  }
}

TEST(Recolor, OfTheWholeLossIsNearTheTruth) {
  const Scene scene = Bright(40, 4);
  const std::vector<double> truth = TruthOf(scene);
  const PhotometricWeights weights;
  test::LinearizedScene<double> linearized(scene, truth, weights);
  const auto rises = MakeForecast(linearized, scene.count);
  double off = 0, all = 0;
  for (int i = 0; i < scene.count; ++i) {
    for (int d = 0; d < kRecolors; ++d) {
      const double rise = test::CostOf(Recolored(scene, i, kSteps[d]), truth, weights) - linearized.cost;
      off += std::abs(rises[static_cast<std::size_t>(i)].rise[d] - rise);
      all += std::abs(rise);
    }
  }
  EXPECT_LT(off, 0.2 * all);
}

TEST(Recolor, CurvatureIsThatOfSquaredErrors) {
  const Scene scene = Bright(7, 5);
  const std::vector<double> truth = TruthOf(scene);
  const PhotometricWeights weights{.l1 = 1, .ssim = 0, .pixel = PixelLinearization::kL2};
  test::LinearizedScene<double> linearized(scene, truth, weights);
  const SplatView<double>& view = linearized.rendered.view;
  const ColorCurvature<double>* curvatures = view.ColorCurvatures(linearized.loss(), linearized.rendered.workspace);
  constexpr double kStep = 0.1;
  for (int i = 0; i < scene.count; ++i) {
    const std::int32_t rank = view.rank_of()[i];
    if (rank < 0) continue;
    const double more = test::CostOf(Recolored(scene, i, kStep), truth, weights);
    const double less = test::CostOf(Recolored(scene, i, -kStep), truth, weights);
    const double* channel = curvatures[rank].channel;
    EXPECT_NEAR((channel[0] + channel[1] + channel[2]) * kStep * kStep, more - 2 * linearized.cost + less,
                1e-9 * linearized.cost)
        << i;
  }
}

TEST(Recolor, AgreesInFloat) {
  const Scene scene = Bright(60, 7);
  const std::vector<double> truth = TruthOf(scene);
  test::LinearizedScene<double> exact(scene, truth, {});
  test::LinearizedScene<float> single(scene, truth, {});
  const auto rises = MakeForecast(exact, scene.count), in_float = MakeForecast(single, scene.count);
  double largest = 0;
  for (const auto& of : rises) largest = std::max(largest, std::abs(of.rise[2]));
  for (std::size_t i = 0; i < rises.size(); ++i) {
    for (int d = 0; d < kRecolors; ++d) EXPECT_NEAR(in_float[i].rise[d], rises[i].rise[d], 2e-4 * largest) << i;
  }
}

}  // namespace
}  // namespace vesta::splat
