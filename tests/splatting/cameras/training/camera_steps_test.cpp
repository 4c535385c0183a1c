// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/training/camera_steps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kernels/core/error.h"

namespace vesta::gs {
namespace {

constexpr FreeUnknowns kPose{.pose = true, .color = false};
constexpr CameraSurroundings kAnywhere{.depth = 2, .most = 10, .done = 0};

// Of a pose, with a turn and a shift that are coupled.
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
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(step[i], wanted[i], 1e-3);  // damped by as much
  // In the last fifth of the stage it falls to a tenth.
  const auto step_at = [&](double done) {
    return CameraStep(kPose, gradient, state.curvature, {.depth = 2, .most = 10, .done = done})[1];
  };
  EXPECT_EQ(step_at(0.79), step[1]);
  EXPECT_NEAR(step_at(0.9), step[1] * std::sqrt(0.1), 1e-12);
  EXPECT_NEAR(step_at(1), step[1] / 10, 1e-12);
}

// An image of twice the size has four times the cost, and the same step.
TEST(CameraStep, OfAnOlderCurvatureIsThatOfTheSizeOfNow) {
  CameraStepState state = CoupledState();
  state.pixels = 1000;
  const std::vector<double> gradient{1, -2, 0.5, 3, 0, -1};
  std::vector<double> larger = gradient;
  for (double& value : larger) value *= 4;
  const std::vector<double> step = CameraStep(kPose, gradient, state.curvature, kAnywhere);
  BringToSize(4000, &state);
  EXPECT_EQ(CameraStep(kPose, larger, state.curvature, kAnywhere), step);
  EXPECT_EQ(state.pixels, 4000);
  CameraStepState unknown;
  BringToSize(4000, &unknown);
  EXPECT_TRUE(unknown.curvature.empty());
}

TEST(CameraStep, GoesNoFurtherThanItMay) {
  CameraStepState state = CoupledState();
  const std::vector<double> gradient{100, 0, 0, 0, 0, 400};
  const CameraSurroundings near{.depth = 2, .most = 0.01, .done = 0};
  const std::vector<double> step = CameraStep(kPose, gradient, state.curvature, near);
  EXPECT_NEAR(step[5], -0.01 * 2, 1e-12) << "the shift, in depths, is the larger";
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

}  // namespace
}  // namespace vesta::gs
