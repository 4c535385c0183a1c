// SPDX-License-Identifier: Apache-2.0
#include "splatting/density/density.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>

#include "kernels/core/archive.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/math/quaternion.h"
#include "tests/splatting/density/density_scene.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

using test::DensityScene;
using test::OpacityOf;

// The threshold is 2 * 5 = 10.
constexpr double kGrowPull = 2, kPrice = 5;
constexpr float kStrong = 50, kWeak = 9;

std::vector<float> Pulls(Index count, float pull) { return std::vector<float>(static_cast<std::size_t>(count), pull); }

DensityOptions OptionsThatSplit() {
  DensityOptions options;
  options.grow_pull = kGrowPull;
  return options;
}

// Densifies once, after a view with these pulls.
void DensifyOnce(DensityScene& scene, const DensityOptions& options, const std::vector<float>& pulls) {
  DensityControl<Host> control(options, 1);
  control.ResetStatistics(scene.model.count);
  scene.Observe(control, pulls);
  test::ModelAdam adam{LearningRates()};
  test::Densify(control, scene.model, adam, kPrice);
}

// The mean of Gaussian i.
std::array<float, 3> MeanOf(const SplatModel& model, Index i) {
  return {model.attribute(0)[i], model.attribute(1)[i], model.attribute(2)[i]};
}
std::array<double, 3> ScalesOf(const SplatModel& model, Index i) {
  std::array<double, 3> scales;
  for (int k = 0; k < 3; ++k) {
    scales[static_cast<std::size_t>(k)] = std::exp(double{model.attribute(splat::kLogScale + k)[i]});
  }
  return scales;
}
using Matrix3 = std::array<std::array<double, 3>, 3>;
Matrix3 RotationOf(const SplatModel& model, Index i) {
  double q[4], R[9];
  for (int k = 0; k < 4; ++k) q[k] = model.attribute(splat::kQuaternion + k)[i];
  RotationFromQuaternion(q, R);
  return {{{R[0], R[1], R[2]}, {R[3], R[4], R[5]}, {R[6], R[7], R[8]}}};
}
Matrix3 CovarianceOf(const SplatModel& model, Index i) {
  const Matrix3 R = RotationOf(model, i);
  const std::array<double, 3> scales = ScalesOf(model, i);
  Matrix3 covariance{};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < 3; ++k) covariance[r][c] += R[r][k] * scales[k] * scales[k] * R[c][k];
    }
  }
  return covariance;
}
// Integral of the optical depth over space, without the common factor (2 pi)^(3/2).
double DepthIntegral(const SplatModel& model, Index i) {
  const std::array<double, 3> scales = ScalesOf(model, i);
  return std::log1p(std::exp(double{model.attribute(splat::kOpacity)[i]})) * scales[0] * scales[1] * scales[2];
}

TEST(Density, LeavesWhatIsPulledLittle) {
  DensityScene scene(8);
  const SplatModel before = scene.model;
  DensifyOnce(scene, OptionsThatSplit(), Pulls(8, kWeak));
  EXPECT_EQ(scene.model.data, before.data);
}

TEST(Density, PriceIsOfTheParametersOfAGaussian) {
  // 3 for the mean, 3 for the scales, 4 for the rotation, 1 for the opacity, 3 for the colour.
  EXPECT_DOUBLE_EQ(GaussianPrice(0.25, 1), 14 * 0.25);
  EXPECT_DOUBLE_EQ(GaussianPrice(0.25, 3), 3 * 14 * 0.25);
}

TEST(Density, ThresholdIsOnTheSumOfPullsAndInPrices) {
  DensityScene scene(4);
  DensityControl<Host> control(OptionsThatSplit(), 1);
  control.ResetStatistics(4);
  for (const float pull : {1.5f, 2.0f, 4.0f}) scene.Observe(control, Pulls(4, pull));
  EXPECT_EQ(control.views(), 3);
  for (Index i = 0; i < 4; ++i) EXPECT_NEAR(control.pull()[i], 7.5, 1e-5);
  // The threshold is twice the price.
  for (const double price : {3.76, 3.74, 0.1}) {
    EXPECT_EQ(control.Decide(scene.model.data.data(), 4, price).count, price > 3.75 ? 4 : 8) << price;
  }
}

TEST(Density, StatisticsAreForgottenAfterwards) {
  DensityScene scene(4);
  DensityControl<Host> control(OptionsThatSplit(), 1);
  control.ResetStatistics(4);
  scene.Observe(control, Pulls(4, kStrong));
  test::ModelAdam adam{LearningRates()};
  test::Densify(control, scene.model, adam, kPrice);
  ASSERT_EQ(scene.model.count, 8);
  EXPECT_EQ(control.views(), 0);
  EXPECT_EQ(std::vector<float>(control.pull().begin(), control.pull().end()), Pulls(8, 0));
  test::Densify(control, scene.model, adam, kPrice);
  EXPECT_EQ(scene.model.count, 8);
  control.CountViews(3);
  EXPECT_EQ(control.views(), 3);
}

TEST(Density, HalvesTogetherKeepMeanCovarianceAndDepth) {
  constexpr Index kCount = 60;
  DensityScene scene(kCount);
  for (Index i = 0; i < kCount; ++i) {
    scene.model.attribute(splat::kOpacity)[i] = -5 + 0.25f * static_cast<float>(i);
  }
  const SplatModel before = scene.model;
  DensifyOnce(scene, OptionsThatSplit(), Pulls(kCount, kStrong));
  const SplatModel& after = scene.model;
  ASSERT_EQ(after.count, 2 * kCount);
  for (Index i = 0; i < kCount; ++i) {
    const Index halves[2] = {2 * i, 2 * i + 1};  // adjacent
    const double whole_depth = DepthIntegral(before, i);
    double depth = 0;
    std::array<double, 3> mean{};
    for (const Index half : halves) {
      EXPECT_NEAR(DepthIntegral(after, half), whole_depth / 2, 1e-5 * whole_depth);
      depth += DepthIntegral(after, half);
      for (std::size_t k = 0; k < 3; ++k) mean[k] += double{MeanOf(after, half)[k]} / 2;
      // All else is copied.
      for (int a = splat::kQuaternion; a < before.num_attributes(); ++a) {
        EXPECT_TRUE(a == splat::kOpacity || after.attribute(a)[half] == before.attribute(a)[i]);
      }
    }
    EXPECT_NEAR(depth, whole_depth, 1e-5 * whole_depth);
    const Matrix3 expected = CovarianceOf(before, i);
    for (std::size_t r = 0; r < 3; ++r) {
      EXPECT_NEAR(mean[r], double{MeanOf(before, i)[r]}, 1e-6);
      for (std::size_t c = 0; c < 3; ++c) {
        double covariance = 0;
        for (const Index half : halves) {
          const std::array<float, 3> at = MeanOf(after, half);
          covariance += (CovarianceOf(after, half)[r][c] + (at[r] - mean[r]) * (at[c] - mean[c])) / 2;
        }
        EXPECT_NEAR(covariance, expected[r][c], 1e-5 * (expected[0][0] + expected[1][1] + expected[2][2]));
      }
    }
  }
}

TEST(Density, HalvesLieAlongTheLongestAxis) {
  constexpr Index kCount = 60;
  DensityScene scene(kCount);
  vesta::test::Random random(3);
  for (Index i = 0; i < kCount; ++i) {
    for (int k = 0; k < 3; ++k) {
      scene.model.attribute(splat::kLogScale + k)[i] =
          static_cast<float>(random.Uniform(-4, -3)) + (k == i % 3 ? 1 : 0);
    }
    for (int k = 0; k < 4; ++k) scene.model.attribute(splat::kQuaternion + k)[i] = static_cast<float>(random.Normal());
  }
  const SplatModel before = scene.model;
  DensifyOnce(scene, OptionsThatSplit(), Pulls(kCount, kStrong));
  ASSERT_EQ(scene.model.count, 2 * kCount);
  for (Index half = 0; half < 2 * kCount; ++half) {
    const Index i = half / 2;
    const int longest = static_cast<int>(i % 3);
    const Matrix3 R = RotationOf(before, i);
    const double sign = half % 2 == 0 ? 1 : -1, scale = ScalesOf(before, i)[static_cast<std::size_t>(longest)];
    for (int k = 0; k < 3; ++k) {
      const double shrinkage = k == longest ? std::log(2) / 2 : 0;
      EXPECT_NEAR(scene.model.attribute(splat::kLogScale + k)[half],
                  before.attribute(splat::kLogScale + k)[i] - shrinkage, 1e-6);
    }
    for (std::size_t r = 0; r < 3; ++r) {
      const double offset = double{MeanOf(scene.model, half)[r]} - double{MeanOf(before, i)[r]};
      EXPECT_NEAR(offset, sign * scale / std::sqrt(2) * R[r][static_cast<std::size_t>(longest)], 1e-6);
    }
  }
}

// A quarter turn about z takes the first axis to y.
TEST(Density, AxesAreThoseOfTheRotatedGaussian) {
  DensityScene scene(1);
  const float scales[3] = {0.2f, 0.1f, 0.05f}, q[4] = {1, 0, 0, 1};
  for (int k = 0; k < 3; ++k) {
    scene.model.attribute(splat::kMean + k)[0] = 0;
    scene.model.attribute(splat::kLogScale + k)[0] = std::log(scales[k]);
  }
  for (int k = 0; k < 4; ++k) scene.model.attribute(splat::kQuaternion + k)[0] = q[k];
  DensifyOnce(scene, OptionsThatSplit(), Pulls(1, kStrong));
  ASSERT_EQ(scene.model.count, 2);
  for (Index half = 0; half < 2; ++half) {
    const std::array<float, 3> mean = MeanOf(scene.model, half);
    EXPECT_NEAR(mean[0], 0, 1e-7);
    EXPECT_NEAR(mean[1], half == 0 ? 0.1414214 : -0.1414214, 1e-6);
    EXPECT_NEAR(mean[2], 0, 1e-7);
    EXPECT_NEAR(ScalesOf(scene.model, half)[0], 0.1414214, 1e-6);
  }
}

// The depth log(1 + exp(logit)) is logit for opaque Gaussians, and exp(logit) for faint ones. exp of an extreme logit
// overflows in float.
TEST(Density, HalvesOfOpaqueAndFaintGaussiansStayFinite) {
  DensityOptions options = OptionsThatSplit();
  options.prune_opa = 0;
  const double at_zero = std::pow(0.5, 1 / std::sqrt(2));  // 1 - opacity of each half
  for (const auto& [logit, expected] : {std::pair{40.0, 40 / std::sqrt(2)},
                                        {100.0, 100 / std::sqrt(2)},
                                        {300.0, 300 / std::sqrt(2)},
                                        {1000.0, 1000 / std::sqrt(2)},
                                        {0.0, std::log((1 - at_zero) / at_zero)},
                                        {-20.0, -20 - std::log(2) / 2},
                                        {-80.0, -80 - std::log(2) / 2}}) {
    SplatModel model = test::RandomModel(1, 1, 1);
    *model.attribute(splat::kOpacity) = static_cast<float>(logit);
    DensityControl<Host> control(options, 1);
    control.ResetStatistics(1);
    control.pull()[0] = kStrong;  // a faint one is not visible in any view
    test::ModelAdam adam{LearningRates()};
    test::Densify(control, model, adam, kPrice);
    ASSERT_EQ(model.count, 2);
    for (Index half = 0; half < 2; ++half) {
      EXPECT_NEAR(model.attribute(splat::kOpacity)[half], expected, 1e-6 * (1 + std::abs(expected))) << logit;
    }
  }
}

TEST(Density, CapIsHardAndGoesToTheStrongest) {
  constexpr Index kCount = 10, kRoom = 3;
  DensityScene scene(kCount);
  DensityOptions options = OptionsThatSplit();
  options.max_gaussians = kCount + kRoom;
  DensityControl<Host> control(options, 1);
  control.ResetStatistics(kCount);
  std::vector<float> pulls;
  for (Index i = 0; i < kCount; ++i) pulls.push_back(kStrong * static_cast<float>(1 + (7 * i) % kCount));
  const SplatModel before = scene.model;
  scene.Observe(control, pulls);
  test::ModelAdam adam{LearningRates()};
  test::Densify(control, scene.model, adam, kPrice);
  ASSERT_EQ(scene.model.count, kCount + kRoom);
  std::vector<Index> split;
  for (Index i = 0, at = 0; i < kCount; ++i) {
    const bool is_split = OpacityOf(scene.model, at) != OpacityOf(before, i);
    if (is_split) split.push_back(i);
    at += is_split ? 2 : 1;
  }
  EXPECT_EQ(split, (std::vector<Index>{1, 4, 7})) << "the largest pulls, 8, 9 and 10";
  for (int round = 0; round < 3; ++round) {
    scene.Observe(control, Pulls(scene.model.count, kStrong));
    test::Densify(control, scene.model, adam, kPrice);
    EXPECT_EQ(scene.model.count, kCount + kRoom);
  }
}

TEST(Density, RoomThatWasNotThereIsNotForgotten) {
  constexpr Index kCount = 10;
  DensityOptions options = OptionsThatSplit();
  options.max_gaussians = 100;
  DensityControl<Host> before(options, 1);
  before.ResetStatistics(kCount);
  before.LimitGaussians(kCount + 4);
  std::string saved;
  ArchiveWriter writer([&](std::string_view bytes) { saved += bytes; });
  before.Visit(writer);
  for (const Index most : {kCount + 2, kCount + 8}) {  // limits of the resumed run
    DensityScene scene(kCount);
    options.max_gaussians = most;
    DensityControl<Host> control(options, 1);
    ArchiveReader reader(saved);
    control.Visit(reader);
    scene.Observe(control, Pulls(kCount, kStrong));
    test::ModelAdam adam{LearningRates()};
    test::Densify(control, scene.model, adam, kPrice);
    EXPECT_EQ(scene.model.count, std::min(most, kCount + 4));
  }
}

// Pruned Gaussians free places.
TEST(Density, PrunesTheTransparentAndTheHuge) {
  DensityScene scene(5);
  scene.model.attribute(splat::kOpacity)[1] = -5.4f;                // opacity 0.0045
  scene.model.attribute(splat::kOpacity)[4] = -5.2f;                // 0.0055
  scene.model.attribute(splat::kLogScale + 2)[3] = std::log(0.9f);  // exceeds the limit for an extent of 2
  DensityOptions options = OptionsThatSplit();
  options.prune_scale3d = 0.4;
  options.max_gaussians = 5;
  const SplatModel before = scene.model;
  DensityControl<Host> control(options, 2);
  control.ResetStatistics(5);
  test::ModelAdam adam{LearningRates()};
  test::Densify(control, scene.model, adam, kPrice);
  ASSERT_EQ(scene.model.count, 3);
  EXPECT_EQ(MeanOf(scene.model, 0), MeanOf(before, 0));
  EXPECT_EQ(MeanOf(scene.model, 1), MeanOf(before, 2));
  EXPECT_EQ(MeanOf(scene.model, 2), MeanOf(before, 4));
  scene.Observe(control, Pulls(3, kStrong));
  test::Densify(control, scene.model, adam, kPrice);
  EXPECT_EQ(scene.model.count, 5);
}

TEST(Density, NeverEmptiesAModel) {
  DensityScene scene(3);
  std::fill_n(scene.model.attribute(splat::kOpacity), 3, -9.0f);
  const SplatModel before = scene.model;
  DensityControl<Host> control({}, 1);
  control.ResetStatistics(3);
  test::ModelAdam adam{LearningRates()};
  test::Densify(control, scene.model, adam, kPrice);
  EXPECT_EQ(scene.model.data, before.data);
}

TEST(Density, ResetLowersOpacities) {
  SplatModel model = test::RandomModel(3, 0, 4);
  model.attribute(splat::kOpacity)[1] = -7;
  test::ModelAdam adam{LearningRates()};
  DensityControl<Host>::LowerOpacities(model.data.data(), model.count);
  EXPECT_NEAR(OpacityOf(model, 0), 0.01, 1e-8);
  EXPECT_EQ(model.attribute(splat::kOpacity)[1], -7);
  EXPECT_NEAR(OpacityOf(model, 2), 0.01, 1e-8);
}

// Unchanged Gaussians keep moving by momentum, both halves follow the new gradient.
TEST(Density, MomentsFollowTheModel) {
  DensityScene scene(4);
  test::ModelAdam adam{LearningRates()};
  std::vector<float> gradient(scene.model.data.size(), 1.0f);
  adam.Step(scene.model, gradient.data(), scene.model.num_attributes(), 1);
  DensityControl<Host> control(OptionsThatSplit(), 1);
  control.ResetStatistics(4);
  scene.Observe(control, {kStrong, 0, 0, kStrong});
  test::Densify(control, scene.model, adam, kPrice);
  ASSERT_EQ(scene.model.count, 6);
  const SplatModel before = scene.model;
  gradient.assign(scene.model.data.size(), -1e-3f);
  adam.Step(scene.model, gradient.data(), scene.model.num_attributes(), 1);
  for (Index i = 0; i < 6; ++i) {
    const bool is_new = i < 2 || i > 3;
    EXPECT_EQ(MeanOf(scene.model, i)[0] > MeanOf(before, i)[0], is_new) << "halves start without moments";
  }
}

}  // namespace
}  // namespace vesta::gs
