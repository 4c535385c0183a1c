// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "solver/internal/trust_region/step_control.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

TEST(StepDoubt, SpeaksOfWhatRejectedStepsWereToGain) {
  StepDoubt doubt;
  EXPECT_EQ(doubt.Words(false, 0), "");
  doubt.OnReject(3, true);
  doubt.OnReject(1, true);
  EXPECT_THAT(doubt.Words(false, 2), HasTokens("3.000e+00"));
  EXPECT_EQ(doubt.Words(false, 3), "") << "rounding";
  EXPECT_EQ(doubt.Words(true, 0), "") << "a shorter one was accepted";
  doubt.OnReject(std::numeric_limits<double>::quiet_NaN(), true);
  EXPECT_THAT(doubt.Words(false, 2), HasTokens("3.000e+00"));
  doubt.OnAccept();
  EXPECT_EQ(doubt.Words(false, 0), "");
}

TEST(StepDoubt, AnIncreaseSaysMoreThanADecrease) {
  StepDoubt doubt;
  doubt.OnReject(5, true);
  doubt.OnReject(-2, true);
  EXPECT_THAT(doubt.Words(false, 1), HasTokens("J^T"));
  EXPECT_EQ(doubt.IncreaseWords(1), doubt.Words(false, 1));
  EXPECT_EQ(doubt.IncreaseWords(2), "");
}

TEST(StepDoubt, StepsToWhereThereIsNoCostSpeakAgainstAcceptedOnesToo) {
  StepDoubt doubt;
  doubt.OnReject(5, false);
  for (const bool accepted : {false, true}) EXPECT_THAT(doubt.Words(accepted, 1), HasTokens("5.000e+00"));
  EXPECT_EQ(doubt.Words(true, 5), "");
}

}  // namespace
}  // namespace vesta
