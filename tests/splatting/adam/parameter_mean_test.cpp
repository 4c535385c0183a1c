// SPDX-License-Identifier: Apache-2.0
#include "splatting/adam/parameter_mean.h"

#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "splatting/adam/adam_options.h"
#include "tests/splatting/train/training_scene.h"

namespace vesta::gs {
namespace {

using test::ShortTraining;
using test::TrainingScene;

// Of term t of T: (k + 1) / (t + k), reduced by each later term.
double Weight(int t, int terms) {
  constexpr double k = ParameterMean<CpuBackend<float>>::kExponent;
  double weight = (k + 1) / (t + k);
  for (int later = t + 1; later <= terms; ++later) weight *= (later - 1) / (later + k);
  return weight;
}

TEST(ParameterMean, IsThatOfAllSinceTheStart) {
  ParameterMean<CpuBackend<float>> mean;
  const auto add = [&](std::vector<float> x) {
    mean.Add(HostSpan<const float>(x.data(), static_cast<Index>(x.size())));
  };
  EXPECT_TRUE(mean.empty());
  add({1, -2});
  add({2, 2});
  add({6, 3});
  ASSERT_EQ(mean.value().size(), 2);
  const double a = Weight(1, 3), b = Weight(2, 3), c = Weight(3, 3);
  EXPECT_NEAR(a + b + c, 1, 1e-12);
  EXPECT_LT(a, b);
  EXPECT_LT(b, c);
  EXPECT_NEAR(mean.value()[0], a + 2 * b + 6 * c, 1e-5);
  EXPECT_NEAR(mean.value()[1], -2 * a + 2 * b + 3 * c, 1e-5);
  mean.Clear();
  EXPECT_TRUE(mean.empty());
  add({5});
  ASSERT_EQ(mean.value().size(), 1);
  EXPECT_EQ(mean.value()[0], 5);
}

// With averaging off, rows contain the parameters of each iteration.
TEST(ParameterMean, IsWhatTheAdamStageLeaves) {
  constexpr int kIterations = 60;
  const Scene scene = TrainingScene();
  TrainOptions options = ShortTraining(kIterations, 0);
  options.adam.evaluations = kIterations;
  options.adam.averaging_fraction = 0;
  options.pruning.shrink_unseen = false;  // so that rows contain all Gaussians
  std::map<int, std::vector<float>> iterates;
  TrainCallbacks callbacks;
  callbacks.evaluated = [&](const HistoryRow& row, const splat::Model<float>& x) {
    const Index size = x.count * splat::NumAttributes(x.sh_degree);
    iterates[row.iteration].assign(x.x, x.x + size);
  };
  const std::vector<float> last = Train(scene, options, {}, callbacks).model.data;
  ASSERT_EQ(iterates.size(), static_cast<std::size_t>(kIterations));
  EXPECT_TRUE(last == iterates[kIterations]);

  options.adam.averaging_fraction = 0.3;
  std::erase_if(iterates, [&](const auto& row) {
    const double it = row.first;
    return !Averages(options.adam, {(it - 1) / kIterations, it / kIterations}, row.first);
  });
  ASSERT_EQ(iterates.size(), 4u);
  std::vector<double> expected(last.size(), 0);
  int t = 0;
  for (const auto& [it, x] : iterates) {
    const double weight = Weight(++t, 4);
    ASSERT_EQ(x.size(), expected.size());
    for (std::size_t i = 0; i < x.size(); ++i) expected[i] += weight * x[i];
  }
  const std::vector<float> mean = Train(scene, options, {}, {}).model.data;
  ASSERT_EQ(mean.size(), expected.size());
  for (std::size_t i = 0; i < mean.size(); ++i) EXPECT_NEAR(mean[i], expected[i], 1e-5) << i;
  EXPECT_FALSE(mean == last);
}

}  // namespace
}  // namespace vesta::gs
