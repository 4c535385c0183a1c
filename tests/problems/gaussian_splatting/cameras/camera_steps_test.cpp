#include "problems/gaussian_splatting/cameras/camera_steps.h"

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
  CameraOptions options;
  options.momentum = 0;
  const std::vector<double> step = CameraStep(options, kPose, gradient, kAnywhere, &state);
  ASSERT_EQ(step.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(step[i], wanted[i], 1e-3);  // damped by as much
  options.step = 0.5;
  EXPECT_NEAR(CameraStep(options, kPose, gradient, kAnywhere, &state)[1], step[1] / 2, 1e-15);
}

// Of steps that stay alike the sum is 1 / (1 - momentum) times them.
TEST(CameraStep, GoesOnAsBefore) {
  CameraStepState state = CoupledState();
  CameraOptions options;
  options.momentum = 0.5;
  const std::vector<double> gradient{1, -2, 0.5, 3, 0, -1};
  const std::vector<double> first = CameraStep(options, kPose, gradient, kAnywhere, &state);
  const std::vector<double> second = CameraStep(options, kPose, gradient, kAnywhere, &state);
  const std::vector<double> none = CameraStep(options, kPose, std::vector<double>(6, 0), kAnywhere, &state);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(second[i], 1.5 * first[i], 1e-12);
    EXPECT_NEAR(none[i], 0.75 * first[i], 1e-12);
  }
  // What a step may not do at once the next one does not owe.
  CameraStepState held = CoupledState();
  const CameraSurroundings near{.depth = 2, .most = 1e-4, .done = 0};
  const std::vector<double> cut = CameraStep(options, kPose, gradient, near, &held);
  EXPECT_EQ(CameraStep(options, kPose, std::vector<double>(6, 0), near, &held)[0], cut[0] / 2);
}

// An image of twice the size has four times the cost, and the same step.
TEST(CameraStep, OfAnOlderCurvatureIsThatOfTheSizeOfNow) {
  CameraStepState state = CoupledState();
  state.pixels = 1000;
  CameraOptions options;
  options.momentum = 0;
  const std::vector<double> gradient{1, -2, 0.5, 3, 0, -1};
  std::vector<double> larger = gradient;
  for (double& value : larger) value *= 4;
  const std::vector<double> step = CameraStep(options, kPose, gradient, kAnywhere, &state);
  BringToSize(4000, &state);
  EXPECT_EQ(CameraStep(options, kPose, larger, kAnywhere, &state), step);
  EXPECT_EQ(state.pixels, 4000);
  CameraStepState unknown;
  BringToSize(4000, &unknown);
  EXPECT_TRUE(unknown.curvature.empty());
}

TEST(CameraStep, GoesNoFurtherThanItMay) {
  CameraStepState state = CoupledState();
  const std::vector<double> gradient{100, 0, 0, 0, 0, 400};
  const CameraSurroundings near{.depth = 2, .most = 0.01, .done = 0};
  const std::vector<double> step = CameraStep({}, kPose, gradient, near, &state);
  EXPECT_NEAR(step[5], -0.01 * 2, 1e-12) << "the shift, in depths, is the larger";
  EXPECT_LT(step[0], 0);
  EXPECT_GT(step[0], -0.01);
}

TEST(CameraStep, StaysWhereNothingIsKnown) {
  CameraStepState blind;
  blind.curvature.assign(36, 0);
  EXPECT_EQ(CameraStep({}, kPose, std::vector<double>(6, 0), kAnywhere, &blind), std::vector<double>(6, 0));
  CameraStepState state = CoupledState();
  std::vector<double> gradient(6, 1);
  gradient[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(CameraStep({}, kPose, gradient, kAnywhere, &state), std::vector<double>(6, 0));
  state.curvature.resize(35);
  EXPECT_THROW(CameraStep({}, kPose, std::vector<double>(6, 1), kAnywhere, &state), Error);
}

TEST(CameraStep, OfAdamIsItsRateAtFirst) {
  CameraOptions options;
  options.rule = CameraRule::kAdam;
  options.adam_rotation = 1e-3, options.adam_translation = 2e-3;
  CameraStepState state;
  const std::vector<double> gradient{5, -0.1, 0, 7, 0, -2};
  const std::vector<double> step = CameraStep(options, kPose, gradient, kAnywhere, &state);
  const std::vector<double> wanted{-1e-3, 1e-3, 0, -4e-3, 0, 4e-3};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(step[i], wanted[i], 1e-12);
  CameraStepState late;
  EXPECT_NEAR(CameraStep(options, kPose, gradient, {.depth = 2, .most = 10, .done = 1}, &late)[0], -1e-5, 1e-12);
}

}  // namespace
}  // namespace vesta::gs
