// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "splatting/io/splats/packed_values.h"

namespace vesta::gs {
namespace {

double Opacity(float logit) { return 1 / (1 + std::exp(-static_cast<double>(logit))); }

TEST(OpacityByte, IsTheNearestOfWhatIsSeen) {
  EXPECT_EQ(OpacityByte(0), 128);
  for (float logit = -9; logit < 5.5f; logit += 0.01f) {
    const double opacity = Opacity(logit), again = Opacity(OpacityLogit(OpacityByte(logit)));
    EXPECT_NEAR(again, opacity, (opacity < 1 / 255.0 ? 1 : 0.5) / 255 + 1e-6) << logit;
    if (opacity < 1 / 255.0) {
      EXPECT_LT(again, 1 / 255.0) << logit;
    }
  }
  for (int byte = 2; byte < 255; ++byte) {
    EXPECT_EQ(OpacityByte(OpacityLogit(static_cast<std::uint8_t>(byte))), byte);
  }
}

TEST(OpacityByte, HasNoInfiniteLogits) {
  for (const float large : {50.0f, 1e30f}) {
    EXPECT_EQ(OpacityByte(large), 254);
    EXPECT_EQ(OpacityByte(-large), 0);
  }
  EXPECT_GT(OpacityLogit(255), OpacityLogit(254));
  EXPECT_LT(OpacityLogit(0), OpacityLogit(1));
  EXPECT_LT(OpacityLogit(255), 7.0f);
  EXPECT_GT(OpacityLogit(0), -7.0f);
}

}  // namespace
}  // namespace vesta::gs
