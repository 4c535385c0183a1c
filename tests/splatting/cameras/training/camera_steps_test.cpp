// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/training/camera_steps.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "kernels/core/error.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

TEST(CameraSchedule, AMeanTurnIsFreeTheSoonerTheNarrowerTheFilter) {
  EXPECT_EQ(MeanRotationFreeFrom(splat::kEps2d), 0.65);
  EXPECT_EQ(MeanRotationFreeFrom(splat::kMaxEps2d), 0.65);
  EXPECT_NEAR(MeanRotationFreeFrom(splat::kEps2d / 2), 0.55, 1e-12);
  EXPECT_GT(MeanRotationFreeFrom(splat::kMinEps2d), 0.45);
  EXPECT_LT(MeanRotationFreeFrom(splat::kMinEps2d), 0.46);
}

constexpr FreeUnknowns kPose{.pose = true, .color = false};
constexpr CameraStepContext kAnywhere{.depth = 2, .most = 10, .done = 0};

// A rotation and a shift are coupled.
CameraStepState CoupledState() {
  CameraStepState state;
  state.curvature.assign(36, 0);
  for (std::size_t i = 0; i < 6; ++i) state.curvature[7 * i] = 100.0 + static_cast<double>(i);
  state.curvature[6 * 1 + 3] = state.curvature[6 * 3 + 1] = 60;
  return state;
}

TEST(CameraStep, IsGaussNewtons) {
  CameraStepState state = CoupledState();
  const std::vector<double> wanted{0.1, -0.2, 0.05, 0.3, 0, -0.1};
  std::vector<double> gradient(6, 0);
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) gradient[i] -= state.curvature[6 * i + j] * wanted[j];
  }
  const std::vector<double> step = CameraStep(kPose, gradient, state.curvature, kAnywhere);
  ASSERT_EQ(step.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(step[i], wanted[i], 1e-3);  // damping changes it by as much
  // In the last fifth of the stage, down to a tenth.
  const auto step_at = [&](double done) {
    return CameraStep(kPose, gradient, state.curvature, {.depth = 2, .most = 10, .done = done})[1];
  };
  EXPECT_EQ(step_at(0.79), step[1]);
  EXPECT_NEAR(step_at(0.9), step[1] * std::sqrt(0.1), 1e-12);
  EXPECT_NEAR(step_at(1), step[1] / 10, 1e-12);
}

// Doubling the image size multiplies the cost by four, not the step.
TEST(CameraStep, OfAnOlderCurvatureIsThatOfTheSizeOfNow) {
  CameraStepState state = CoupledState();
  state.pixels = 1000;
  const std::vector<double> gradient{1, -2, 0.5, 3, 0, -1};
  std::vector<double> larger = gradient;
  for (double& value : larger) value *= 4;
  const std::vector<double> step = CameraStep(kPose, gradient, state.curvature, kAnywhere);
  RescaleCurvature(4000, &state);
  EXPECT_EQ(CameraStep(kPose, larger, state.curvature, kAnywhere), step);
  EXPECT_EQ(state.pixels, 4000);
  CameraStepState unknown;
  RescaleCurvature(4000, &unknown);
  EXPECT_TRUE(unknown.curvature.empty());
}

TEST(CameraStep, GoesNoFurtherThanItMay) {
  CameraStepState state = CoupledState();
  const std::vector<double> gradient{100, 0, 0, 0, 0, 400};
  const CameraStepContext near{.depth = 2, .most = 0.01, .done = 0};
  const std::vector<double> step = CameraStep(kPose, gradient, state.curvature, near);
  EXPECT_NEAR(step[5], -0.01 * 2, 1e-12) << "the shift, in units of depth, is larger";
  EXPECT_LT(step[0], 0);
  EXPECT_GT(step[0], -0.01);
}

TEST(CameraStep, StaysWhereNothingIsKnown) {
  const std::vector<double> blind(36, 0);
  EXPECT_EQ(CameraStep(kPose, std::vector<double>(6, 0), blind, kAnywhere), std::vector<double>(6, 0));
  CameraStepState state = CoupledState();
  std::vector<double> gradient(6, 1);
  gradient[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(CameraStep(kPose, gradient, state.curvature, kAnywhere), std::vector<double>(6, 0));
  state.curvature.resize(35);
  EXPECT_THROW(CameraStep(kPose, std::vector<double>(6, 1), state.curvature, kAnywhere), Error);
}

constexpr FreeUnknowns kAll{true, true, true};
constexpr double kNoLimit = 10;

// A view's quadratic system, with its minimum at `wanted`.
struct ViewSystem {
  std::vector<double> curvature, gradient;

  ViewSystem(const std::vector<double>& wanted, std::uint64_t seed) {
    const auto n = static_cast<Eigen::Index>(wanted.size());
    test::Random random(seed);
    Eigen::MatrixXd J(3 * n, n);
    for (double& value : J.reshaped()) value = random.Normal();
    const Eigen::MatrixXd H = J.transpose() * J;
    const Eigen::VectorXd g = -H * Eigen::Map<const Eigen::VectorXd>(wanted.data(), n);
    curvature.assign(H.data(), H.data() + H.size());
    gradient.assign(g.begin(), g.end());
  }
};

// Random, with the lens parameters last.
std::vector<double> Wanted(const FreeUnknowns& free, const splat::LensTangent& lens, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<double> wanted;
  for (int k = 0; k < free.OwnOfView().num_tangent(); ++k) wanted.push_back(0.1 * random.Normal());
  wanted.insert(wanted.end(), lens.v, lens.v + free.lens_tangent());
  return wanted;
}

// Three views share a lens and have different poses. The lens step combines them. A view's own step plus its response
// to the lens (FollowLensStep) gives the rest.
TEST(LensStep, IsGaussNewtonsOfAllUnknownsTogether) {
  for (const FreeUnknowns& free : {kAll, FreeUnknowns{.pose = true, .color = false, .lens = true}}) {
    const splat::LensTangent lens{{0.02, -0.01, 0.03, 0.01}};
    LensSystem system;
    std::vector<ViewSystem> views;
    for (std::uint64_t v = 0; v < 3; ++v) {
      views.emplace_back(Wanted(free, lens, v), 10 + v);
      AddToLens(free, views[v].gradient, views[v].curvature, &system);
    }
    EXPECT_EQ(system.views, 3);
    const splat::LensTangent found = LensStep(system, 1, kNoLimit);
    for (int k = 0; k < splat::kLensTangent; ++k) EXPECT_NEAR(found.v[k], lens.v[k], 5e-4);  // for the damping
    for (std::uint64_t v = 0; v < 3; ++v) {
      const std::vector<double> own = CameraStep(free, views[v].gradient, views[v].curvature, {1, kNoLimit, 0}),
                                follow = FollowLensStep(free, views[v].curvature, found),
                                wanted = Wanted(free, lens, v);
      ASSERT_EQ(own.size(), wanted.size());
      ASSERT_EQ(follow.size(), wanted.size());
      for (std::size_t i = 0; i < wanted.size(); ++i) EXPECT_NEAR(own[i] + follow[i], wanted[i], 2e-3) << i;
    }
    const splat::LensTangent half = LensStep(system, 0.5, kNoLimit), near = LensStep(system, 1, 0.003);
    for (int k = 0; k < splat::kLensTangent; ++k) {
      EXPECT_NEAR(half.v[k], found.v[k] / 2, 1e-15);
      EXPECT_NEAR(near.v[k], found.v[k] * 0.003 / found.v[2], 1e-6) << "the largest component equals the limit";
    }
  }
}

TEST(LensStep, StaysWhereNothingIsKnown) {
  const LensSystem nothing;
  for (const double value : LensStep(nothing, 1, kNoLimit).v) EXPECT_EQ(value, 0);
  LensSystem system;
  std::vector<double> gradient(16, 1);
  gradient[3] = std::numeric_limits<double>::quiet_NaN();
  AddToLens(kAll, gradient, ViewSystem(Wanted(kAll, {}, 1), 2).curvature, &system);
  EXPECT_EQ(system.views, 0);
  EXPECT_THROW(AddToLens(kAll, gradient, std::vector<double>(144, 1), &system), Error);
  std::vector<double> no_numbers = ViewSystem(Wanted(kAll, {}, 1), 2).curvature;
  no_numbers[12 * 16] = std::numeric_limits<double>::quiet_NaN();  // couples lens and pose
  const splat::LensTangent lens{{0.1, 0.1, 0, 0}};
  const std::vector<double> follow = FollowLensStep(kAll, no_numbers, lens);
  for (int k = 0; k < kAll.OwnOfView().num_tangent(); ++k) EXPECT_EQ(follow[static_cast<std::size_t>(k)], 0);
}

TEST(LensChange, IsOfTheGivenLensAndComposes) {
  const splat::Lens given{100, 120, 50, 40};
  EXPECT_TRUE(LensChange{}.Of(given) == given);
  const LensChange change = Compose({{0.1, 0.2, 0.01, -0.02}}, {});
  const splat::Lens lens = change.Of(given);
  EXPECT_NEAR(lens.fx, 100 * std::exp(0.1), 1e-12);
  EXPECT_NEAR(lens.cy, 40 - 0.02 * 120, 1e-12);
  // A second change applies to the lens after the first.
  const splat::Lens twice = Compose({{0, 0, 0.05, 0}}, change).Of(given);
  EXPECT_NEAR(twice.cx, lens.cx + 0.05 * lens.fx, 1e-12);
  // The change also holds for a smaller image.
  const splat::Lens small = change.Of(given.Scaled(0.5, 0.5));
  EXPECT_NEAR(small.cx, lens.cx / 2, 1e-12);
  EXPECT_NEAR(small.fy, lens.fy / 2, 1e-12);
}

}  // namespace

}  // namespace vesta::gs
