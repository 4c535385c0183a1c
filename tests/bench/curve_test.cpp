// SPDX-License-Identifier: Apache-2.0
#include "bench/training_race/curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "kernels/core/check.h"
#include "tests/bench/curves.h"

namespace vesta::bench {
namespace {

using test::Row;

Curve Slower(Curve curve, double factor) {
  for (gs::HistoryRow& row : curve) row.seconds *= factor;
  return curve;
}

const Curve kCurve = {Row(1, .5, 25, .80), Row(2, .4, 26, .84), Row(4, .3, 27, .88)};

TEST(MedianCurve, TakesTheMedianOfTheSeconds) {
  const Curve median = MedianCurve({Slower(kCurve, 3), kCurve, Slower(kCurve, 1.5)});
  ASSERT_EQ(median.size(), 3u);
  EXPECT_EQ(median[1].seconds, 3);
  EXPECT_EQ(median[2].seconds, 6);
  EXPECT_EQ(median[2].cost, .3);
}

TEST(MedianCurve, EndsWhereALimitOfTimeEndedOneRepeat) {
  Curve stopped = kCurve;
  stopped[1].iteration = 2;  // of a row that the time limit added; kCurve has iteration 3 here
  stopped[1].cost = .45;
  stopped.resize(2);
  EXPECT_EQ(MedianCurve({kCurve, stopped}).size(), 1u);
  stopped.resize(1);
  EXPECT_EQ(MedianCurve({stopped, kCurve}).size(), 1u);
}

TEST(MedianCurve, RefusesRepeatsThatDiffer) {
  Curve other = kCurve;
  other[0].cost = .49;
  EXPECT_THROW(MedianCurve({kCurve, other}), Error);
}

TEST(SecondsToCost, IsTheFirstRowAtOrBelow) {
  EXPECT_EQ(SecondsToCost(kCurve, .4), 2);
  EXPECT_EQ(SecondsToCost(kCurve, .39), 4);
  EXPECT_TRUE(std::isinf(SecondsToCost(kCurve, .29)));
  EXPECT_EQ(LowestCost(kCurve), .3);
}

TEST(Csv, HasAValueForEachName) {
  std::ostringstream out;
  WriteCsvHeader(out);
  WriteCsv("s", "m", {kCurve[0]}, out);
  EXPECT_EQ(out.str(),
            "scene,method,stage,iteration,seconds,cost,train_psnr,train_ssim,test_psnr,test_ssim,gaussians\n"
            "s,m,adam,2,1.0000,0.50000000,0.00000,0.000000,25.00000,0.800000,0\n");
}

}  // namespace
}  // namespace vesta::bench
