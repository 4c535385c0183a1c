// SPDX-License-Identifier: Apache-2.0
// The value at which half of the light is absorbed agrees with sums of weights.
#include <gtest/gtest.h>

#include <cmath>

#include "kernels/gaussian_splatting/raster/raster_kernels.h"
#include "tests/support/cpu_isas.h"
#include "tests/support/splat_scenes.h"

namespace vesta::splat {
namespace {

using test::RenderedView;
using test::Scene;

template <class S>
std::vector<S> MedianValues(const SplatView<S>& view, MedianKernel<S> kernel,
                            const std::vector<SplatTangent<S>>& values) {
  std::vector<S> planes(static_cast<std::size_t>(3 * view.num_pixels()), S(7));
  const TileLists<S> lists = view.Lists();
  for (Index tile = 0; tile < view.num_tiles(); ++tile) {
    kernel(lists, static_cast<int>(tile), values.data(), planes.data());
  }
  return planes;
}

// 1, 2 and 3 times the splat's rank, counted from 1.
template <class S>
std::vector<SplatTangent<S>> RankValues(const SplatView<S>& view) {
  std::vector<SplatTangent<S>> values(static_cast<std::size_t>(view.num_splats()));
  for (std::size_t rank = 0; rank < values.size(); ++rank) {
    for (int k = 0; k < 3; ++k) values[rank].w[kColor + k] = static_cast<S>(rank + 1) * static_cast<S>(k + 1);
  }
  return values;
}

struct Expected {
  std::vector<int> rank;       // counted from 1; 0: none
  std::vector<double> margin;  // distance from one half of the light absorbed before or behind that splat
};

// The first n splats absorb the sum of their weights, an image of white splats.
Expected BySumsOfWeights(const SplatView<double>& view) {
  const auto pixels = static_cast<std::size_t>(view.num_pixels());
  Expected expected{std::vector<int>(pixels), std::vector<double>(pixels, 1)};
  std::vector<SplatTangent<double>> white(static_cast<std::size_t>(view.num_splats()));
  std::vector<double> sums(3 * pixels);
  for (std::size_t rank = 0; rank < white.size(); ++rank) {
    white[rank].w[kColor] = 1;
    view.ApplyRasterJ(white.data(), sums.data());
    for (std::size_t p = 0; p < pixels; ++p) {
      expected.margin[p] = std::min(expected.margin[p], std::abs(sums[p] - 0.5));
      if (expected.rank[p] == 0 && sums[p] > 0.5) expected.rank[p] = static_cast<int>(rank) + 1;
    }
  }
  return expected;
}

class Median : public testing::TestWithParam<test::SceneOptions> {};
INSTANTIATE_TEST_SUITE_P(Scenes, Median, testing::ValuesIn(test::SceneKinds()),
                         [](const auto& param) { return param.param.name; });

TEST_P(Median, IsTheSplatAtWhichTransmittanceFallsBelowHalf) {
  const Scene scene = test::RandomScene(GetParam(), 2);
  const RenderedView<double> rendered(scene);
  const RenderedView<float> in_float(scene);
  const Expected expected = BySumsOfWeights(rendered.view);
  const std::size_t pixels = expected.rank.size();
  const std::vector<double> found = MedianValues(rendered.view, GetMedianKernel<double>(), RankValues(rendered.view));
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (expected.margin[i % pixels] < 1e-9) continue;
    const std::size_t plane = i / pixels;
    ASSERT_EQ(found[i], expected.rank[i % pixels] * static_cast<double>(plane + 1)) << "entry " << i;
  }
  if (rendered.rank_of() != in_float.rank_of()) return;  // a distant splat is visible in only one precision
  for (const Isa isa : test::CpuIsas()) {
    const std::vector<float> same = MedianValues(in_float.view, FloatMedianKernelFor(isa), RankValues(in_float.view));
    for (std::size_t i = 0; i < same.size(); ++i) {
      if (expected.margin[i % pixels] < 0.01) continue;
      ASSERT_EQ(static_cast<double>(same[i]), found[i]) << "entry " << i << ", set " << static_cast<int>(isa);
    }
  }
}

}  // namespace
}  // namespace vesta::splat
