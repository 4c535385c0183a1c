// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "splatting/cameras/training/camera_steps.h"

namespace vesta::gs {
namespace {

TEST(CameraSchedule, AMeanTurnIsFreeTheSoonerTheNarrowerTheFilter) {
  EXPECT_EQ(MeanTurnFree(splat::kLowPass), 0.65);
  EXPECT_EQ(MeanTurnFree(splat::kMostLowPass), 0.65);
  EXPECT_NEAR(MeanTurnFree(splat::kLowPass / 2), 0.55, 1e-12);
  EXPECT_GT(MeanTurnFree(splat::kLeastLowPass), 0.45);
  EXPECT_LT(MeanTurnFree(splat::kLeastLowPass), 0.46);
}

}  // namespace
}  // namespace vesta::gs
