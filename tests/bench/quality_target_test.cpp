// SPDX-License-Identifier: Apache-2.0
#include "bench/training_race/quality_target.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/bench/curves.h"

namespace vesta::bench {
namespace {

using test::Row;

TEST(BestQuality, IsTheBestAtAnyTimeLessTheTolerances) {
  // Over-fits after 2 s.
  const Curve a = {Row(1, .5, 25, .80), Row(2, .4, 26.5, .850), Row(3, .3, 26, .849)};
  const Curve b = {Row(1, .5, 24, .70), Row(4, .4, 26, .84)};
  const QualityTarget target = BestQuality({&a, &b});
  EXPECT_EQ(target.best_psnr, 26.5);
  EXPECT_EQ(target.best_ssim, .850);
  EXPECT_EQ(target.tolerance_factor, 1);
  EXPECT_DOUBLE_EQ(target.psnr, 26.48);
  EXPECT_DOUBLE_EQ(target.ssim, .849);
  EXPECT_EQ(SecondsTo(target, a), 2);
  EXPECT_TRUE(std::isinf(SecondsTo(target, b)));
  // PSNR and SSIM must be reached together.
  EXPECT_EQ(SecondsTo(target, {Row(1, 0, 27, .8), Row(2, 0, 26, .9), Row(3, 0, 26.481, .8491)}), 3);
}

TEST(BestQuality, WidensBothTolerancesWhereNoRowHoldsBoth) {
  // 26.5 and .860 are on different curves. The last row of a misses SSIM by 5 tolerances, b PSNR by 10.
  const Curve a = {Row(1, .5, 26.5, .80), Row(2, .4, 26.45, .855)};
  const Curve b = {Row(1, .5, 26.3, .860)};
  const QualityTarget target = BestQuality({&a, &b});
  EXPECT_NEAR(target.tolerance_factor, 5, 1e-6);
  EXPECT_NEAR(target.psnr, 26.4, 1e-6);
  EXPECT_NEAR(target.ssim, .855, 1e-6);
  EXPECT_EQ(SecondsTo(target, a), 2);
  EXPECT_TRUE(std::isinf(SecondsTo(target, b)));
}

TEST(BestQuality, RowsOfTheBest) {
  const Curve curve = {Row(1, .5, 25, .80), Row(2, .4, 26, .81), Row(3, .3, 25.5, .82)};
  EXPECT_EQ(BestPsnr(curve).seconds, 2);
  EXPECT_EQ(BestSsim(curve).seconds, 3);
}

}  // namespace
}  // namespace vesta::bench
