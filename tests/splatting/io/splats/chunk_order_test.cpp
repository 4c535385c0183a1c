// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numeric>

#include "problems/gaussian_splatting/model/initialize.h"
#include "splatting/io/splats/compressed_ply.h"
#include "tests/splatting/io/random_splat.h"

namespace vesta::gs {
namespace {

std::vector<Index> Sorted(std::vector<Index> order) {
  std::sort(order.begin(), order.end());
  return order;
}

// The sides of the chunks' bounds, squared and summed over Gaussians.
double Extents(const SplatModel& model, const std::vector<Index>& order, std::size_t chunk) {
  double sum = 0;
  for (std::size_t begin = 0; begin < order.size(); begin += chunk) {
    const std::size_t end = std::min(begin + chunk, order.size());
    for (int k = 0; k < 3; ++k) {
      double low = 1e300, high = -1e300;
      for (std::size_t i = begin; i < end; ++i) {
        low = std::min<double>(low, model.attribute(k)[order[i]]);
        high = std::max<double>(high, model.attribute(k)[order[i]]);
      }
      sum += static_cast<double>(end - begin) * (high - low) * (high - low);
    }
  }
  return sum;
}

TEST(ChunkOrder, HoldsEveryGaussianOnce) {
  for (const Index count : {0, 1, 7, 8, 9, 100, 5000}) {
    const SplatModel model = RandomSplat(0, count);
    std::vector<Index> all(static_cast<std::size_t>(count));
    std::iota(all.begin(), all.end(), Index{0});
    EXPECT_EQ(Sorted(ChunkOrder(model, 8)), all) << count;
  }
}

// Some Gaussians far out, as a sky is: a curve's chunks leap.
TEST(ChunkOrder, ChunksAreNarrowerThanThoseOfTheCurve) {
  SplatModel model = RandomSplat(0, 5000);
  for (Index i = 0; i < model.count; i += 20) {
    for (int k = 0; k < 3; ++k) model.attribute(k)[i] *= 30;
  }
  EXPECT_LT(Extents(model, ChunkOrder(model, 64), 64), 0.7 * Extents(model, SpatialOrder(model), 64));
}

TEST(ChunkOrder, TakesWhatIsAllInOnePlace) {
  SplatModel model;
  model.Resize(0, 1000);
  EXPECT_EQ(Sorted(ChunkOrder(model, 10)).size(), 1000u);
  std::fill_n(model.attribute(0), 500, 3e38f);
  std::fill_n(model.attribute(1), 100, -3e38f);
  EXPECT_EQ(Sorted(ChunkOrder(model, 10)).size(), 1000u);
}

}  // namespace
}  // namespace vesta::gs
