// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/packed_values.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <utility>

#include "kernels/math/quaternion.h"
#include "kernels/math/spherical_harmonics.h"

namespace vesta::gs {
namespace {

class HalfTurn : public testing::TestWithParam<int> {
 protected:
  float Sign(int attribute) const { return HalfTurnSign(attribute, GetParam()); }
  // On the diagonal of the rotation matrix.
  double Turn(std::size_t k) const { return static_cast<int>(k) == GetParam() ? 1 : -1; }
};

INSTANTIATE_TEST_SUITE_P(Axes, HalfTurn, testing::Range(0, 3));

TEST_P(HalfTurn, TurnsMeans) {
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(Sign(splat::kMean + k), Turn(static_cast<std::size_t>(k)));
    EXPECT_EQ(Sign(splat::kLogScale + k), 1);
  }
  EXPECT_EQ(Sign(splat::kOpacity), 1);
}

// The axes of the covariance agree up to signs, which do not matter.
TEST_P(HalfTurn, TurnsRotations) {
  const std::array<double, 4> q = {0.3, -0.7, 0.5, 0.9};
  std::array<double, 4> turned;
  for (std::size_t k = 0; k < 4; ++k) turned[k] = Sign(splat::kQuaternion + static_cast<int>(k)) * q[k];
  std::array<double, 9> R, R_turned;
  RotationFromQuaternion(q.data(), R.data());
  RotationFromQuaternion(turned.data(), R_turned.data());
  for (std::size_t column = 0; column < 3; ++column) {
    double product = 0;
    for (std::size_t row = 0; row < 3; ++row) product += Turn(row) * R[3 * row + column] * R_turned[3 * row + column];
    EXPECT_NEAR(std::abs(product), 1, 1e-12) << column;
  }
}

// The rotated splat has the same colours in the rotated directions.
TEST_P(HalfTurn, TurnsHarmonics) {
  for (const std::array<double, 3>& d :
       {std::array<double, 3>{0.48, 0.6, 0.64}, {-0.36, 0.48, -0.8}, {0, 0.6, 0.8}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
    std::array<double, kMaxShCoefficients> basis, turned;
    ShBasis<3>(d[0], d[1], d[2], basis.data());
    ShBasis<3>(d[0] * Turn(0), d[1] * Turn(1), d[2] * Turn(2), turned.data());
    for (std::size_t k = 0; k < basis.size(); ++k) {
      for (int channel = 0; channel < 3; ++channel) {
        const double sign = Sign(splat::kSh + 3 * static_cast<int>(k) + channel);
        EXPECT_NEAR(sign * turned[k], basis[k], 1e-12) << k;
      }
    }
  }
}

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

TEST(SmallestThree, GivesTheRotationBack) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 1000; ++trial) {
    std::array<double, 4> q;
    double norm2 = 0;
    for (double& value : q) {
      value = static_cast<double>(random() % 2001) / 1000 - 1;
      norm2 += value * value;
    }
    if (norm2 == 0) continue;
    const SmallestThree three = ToSmallestThree(q);
    for (const double value : three.rest) EXPECT_LE(std::abs(value), kLargestOfSmallest + 1e-12);
    const std::array<double, 4> again = FromSmallestThree(three);
    EXPECT_GE(again[static_cast<std::size_t>(three.largest)], 0.5);
    const double sign = std::copysign(1.0, q[static_cast<std::size_t>(three.largest)]);
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(again[k], sign * q[k] / std::sqrt(norm2), 1e-12);
  }
}

TEST(SmallestThree, NumbersOfNoRotationHaveNoLargest) {
  EXPECT_EQ(FromSmallestThree({1, {0.7, 0.7, -0.7}}), (std::array<double, 4>{0.7, 0, 0.7, -0.7}));
}

TEST(HalfBits, AreBinary16) {
  for (const auto& [bits, value] : {std::pair<int, float>{0x3c00, 1},
                                    {0xc000, -2},
                                    {0x3555, 0.333251953125f},
                                    {0x7bff, 65504},
                                    {0x0400, 0x1p-14f},
                                    {0x03ff, 0x1.ff8p-15f},
                                    {0x0001, 0x1p-24f},
                                    {0x8000, 0}}) {
    EXPECT_EQ(FromHalfBits(static_cast<std::uint16_t>(bits)), value) << bits;
  }
  EXPECT_TRUE(std::signbit(FromHalfBits(0x8000)));
  for (const int bits : {0x7c00, 0xfc00, 0x7e00}) {
    EXPECT_TRUE(std::isnan(FromHalfBits(static_cast<std::uint16_t>(bits)))) << bits;
  }
}

TEST(LogScale, IsFiniteForZero) {
  EXPECT_EQ(LogScaleOf(1), 0);
  EXPECT_NEAR(LogScaleOf(0), -25 * std::log(2.0), 1e-5);
  EXPECT_EQ(LogScaleOf(-0.0f), LogScaleOf(0));
  EXPECT_TRUE(std::isnan(LogScaleOf(-1)));
}

TEST(Color, IsOfTheFirstCoefficient) {
  EXPECT_EQ(ColorOf(0), 0.5);
  EXPECT_NEAR(ColorOf(1), 0.5 + 0.5 / std::sqrt(3.14159265358979), 1e-12);
  EXPECT_NEAR(DcOf(ColorOf(-1.25)), -1.25, 1e-12);
}

}  // namespace

}  // namespace vesta::gs
