// SPDX-License-Identifier: Apache-2.0
#include "kernels/math/half.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/random.h"

namespace vesta {
namespace {

TEST(Half, EveryNormalNumberRoundTrips) {
  for (std::uint32_t bits = 0; bits < 0x10000; ++bits) {
    const std::uint32_t exponent = bits >> 10 & 0x1f;
    if (exponent == 0x1f || (exponent == 0 && (bits & 0x3ff) != 0)) continue;
    const Half half{static_cast<std::uint16_t>(bits)};
    const double expected =
        exponent == 0 ? 0 : std::ldexp(1 + (bits & 0x3ff) / 1024.0, static_cast<int>(exponent) - 15);
    ASSERT_EQ(FromHalf(half), (bits & 0x8000) != 0 ? -expected : expected) << bits;
    ASSERT_EQ(ToHalf(FromHalf(half)).bits, bits);
  }
}

TEST(Half, RoundsToTheNearest) {
  test::Random random(1);
  for (int k = 0; k < 100000; ++k) {
    const auto x = static_cast<float>(random.LogUniform(kSmallestHalf, kLargestHalf) * (k % 2 == 0 ? 1 : -1));
    ASSERT_LE(std::abs(FromHalf(ToHalf(x)) - x), 0x1p-11 * std::abs(x)) << x;
  }
  // Ties go to an even last bit, also at the next power of two.
  EXPECT_EQ(FromHalf(ToHalf(1 + 0x1p-11f)), 1);
  EXPECT_EQ(FromHalf(ToHalf(1 + 3 * 0x1p-11f)), 1 + 0x1p-9f);
  EXPECT_EQ(FromHalf(ToHalf(2 - 0x1p-11f)), 2);
}

TEST(Half, OutOfRangeNumbersBecomeZeroOrTheLargest) {
  EXPECT_EQ(FromHalf(ToHalf(std::nextafter(kSmallestHalf, 0.0f))), 0);
  EXPECT_EQ(FromHalf(ToHalf(kSmallestHalf)), kSmallestHalf);
  for (const float x :
       {kLargestHalf, std::nextafter(kLargestHalf, 1e9f), 1e30f, std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(FromHalf(ToHalf(x)), kLargestHalf);
    EXPECT_EQ(FromHalf(ToHalf(-x)), -kLargestHalf);
  }
  EXPECT_TRUE(std::isfinite(FromHalf(ToHalf(std::numeric_limits<float>::quiet_NaN()))));
}

}  // namespace
}  // namespace vesta
