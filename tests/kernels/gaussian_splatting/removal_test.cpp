// SPDX-License-Identifier: Apache-2.0
// Predictions of the removal pass agree with the loss without the splat.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/kernels/gaussian_splatting/linearized_scene.h"

namespace vesta::splat {
namespace {

using test::Open;
using test::Scene;
using test::TruthOf;

template <class S>
struct Foretold {
  std::vector<double> rises;
  double cost;

  Foretold(const Scene& scene, const std::vector<double>& truth, const PhotometricWeights& weights)
      : rises(static_cast<std::size_t>(scene.count)) {
    test::LinearizedScene<S> linearized(scene, truth, weights);
    linearized.rendered.view.AddRemovalRises(linearized.loss(), rises.data(), linearized.rendered.workspace);
    cost = linearized.cost;
  }
};

double CostWithout(Scene scene, int gaussian, const std::vector<double>& truth, const PhotometricWeights& weights) {
  scene.At(kOpacity, gaussian) = -100;
  return test::CostOf(scene, truth, weights);
}

std::vector<int> Communicator(const std::vector<double>& values) {
  std::vector<int> order(values.size()), rank(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return values[static_cast<std::size_t>(a)] < values[static_cast<std::size_t>(b)]; });
  for (std::size_t k = 0; k < order.size(); ++k) rank[static_cast<std::size_t>(order[k])] = static_cast<int>(k);
  return rank;
}

TEST(Removal, IsExactForALossWithoutSsim) {
  const Scene scene = test::RandomScene(Open(7), 3);
  const std::vector<double> truth = TruthOf(scene);
  for (const auto pixel : {PixelLinearization::kIrls, PixelLinearization::kL2}) {
    const PhotometricWeights weights{.l1 = 1, .ssim = 0, .pixel = pixel};
    const Foretold<double> foretold(scene, truth, weights);
    for (int i = 0; i < scene.count; ++i) {
      const double rise = CostWithout(scene, i, truth, weights) - foretold.cost;
      EXPECT_NEAR(foretold.rises[static_cast<std::size_t>(i)], rise, 1e-10 * foretold.cost) << i;
    }
  }
}

TEST(Removal, OfTheWholeLossIsAccurateEnoughForRanking) {
  const Scene scene = test::RandomScene(Open(60), 4);
  const std::vector<double> truth = TruthOf(scene);
  const PhotometricWeights weights;
  const Foretold<double> foretold(scene, truth, weights);
  std::vector<double> said, true_rise, ratio;
  for (int i = 0; i < scene.count; ++i) {
    const double rise = foretold.rises[static_cast<std::size_t>(i)];
    if (rise == 0) continue;  // not visible
    said.push_back(rise);
    true_rise.push_back(CostWithout(scene, i, truth, weights) - foretold.cost);
    ratio.push_back(said.back() / true_rise.back());
  }
  ASSERT_GT(said.size(), 40U);
  const std::vector<int> a = Communicator(said), b = Communicator(true_rise);
  double squares = 0;
  for (std::size_t k = 0; k < a.size(); ++k) squares += (a[k] - b[k]) * (a[k] - b[k]);
  const auto n = static_cast<double>(a.size());
  EXPECT_GT(1 - 6 * squares / (n * (n * n - 1)), 0.9);
  std::nth_element(ratio.begin(), ratio.begin() + static_cast<std::ptrdiff_t>(ratio.size() / 2), ratio.end());
  EXPECT_NEAR(ratio[ratio.size() / 2], 1, 0.3);
}

TEST(Removal, AgreesInFloat) {
  const Scene scene = test::RandomScene(Open(60), 7);
  const std::vector<double> truth = TruthOf(scene);
  const Foretold<double> exact(scene, truth, {});
  const Foretold<float> single(scene, truth, {});
  double largest = 0;
  for (const double rise : exact.rises) largest = std::max(largest, std::abs(rise));
  for (std::size_t i = 0; i < exact.rises.size(); ++i) {
    EXPECT_NEAR(single.rises[i], exact.rises[i], 2e-4 * largest) << i;
  }
}

}  // namespace
}  // namespace vesta::splat
