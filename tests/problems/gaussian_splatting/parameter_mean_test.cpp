#include "problems/gaussian_splatting/train/parameter_mean.h"

#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "problems/gaussian_splatting/train/adam_schedule.h"
#include "tests/problems/gaussian_splatting/training_scene.h"

namespace vesta::gs {
namespace {

using test::ShortTraining;
using test::TrainingScene;

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
  EXPECT_FLOAT_EQ(mean.value()[0], 3);
  EXPECT_FLOAT_EQ(mean.value()[1], 1);
  mean.StartAnew();
  EXPECT_TRUE(mean.empty());
  add({5});
  ASSERT_EQ(mean.value().size(), 1);
  EXPECT_EQ(mean.value()[0], 5);
}

// The rows of a training without a mean hold the parameters of each iteration.
TEST(ParameterMean, IsWhatTheAdamStageLeaves) {
  constexpr int kIterations = 60;
  const Scene scene = TrainingScene();
  TrainOptions options = ShortTraining(kIterations, 0);
  options.adam.evaluations = kIterations;
  options.adam.average_part = 0;
  std::map<int, std::vector<float>> iterates;
  TrainCallbacks callbacks;
  callbacks.evaluated = [&](const HistoryRow& row, const splat::Model<float>& x) {
    const Index size = x.count * splat::NumAttributes(x.sh_degree);
    iterates[row.iteration].assign(x.x, x.x + size);
  };
  const std::vector<float> last = Train(scene, options, 0, callbacks).model.data;
  ASSERT_EQ(iterates.size(), static_cast<std::size_t>(kIterations));
  EXPECT_TRUE(last == iterates[kIterations]);

  options.adam.average_part = 0.3;
  std::vector<double> expected(last.size(), 0);
  int terms = 0;
  for (const auto& [it, x] : iterates) {
    if (!AveragesAt(options.adam, it, kIterations)) continue;
    ++terms;
    ASSERT_EQ(x.size(), expected.size());
    for (std::size_t i = 0; i < x.size(); ++i) expected[i] += x[i];
  }
  ASSERT_EQ(terms, 4);
  const std::vector<float> mean = Train(scene, options, 0, {}).model.data;
  ASSERT_EQ(mean.size(), expected.size());
  for (std::size_t i = 0; i < mean.size(); ++i) EXPECT_NEAR(mean[i], expected[i] / terms, 1e-5) << i;
  EXPECT_FALSE(mean == last);
}

}  // namespace
}  // namespace vesta::gs
