// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "kernels/math/quaternion.h"
#include "kernels/math/spherical_harmonics.h"
#include "splatting/io/splats/packed_values.h"

namespace vesta::gs {
namespace {

constexpr std::array<double, 3> kTurn = {1, -1, -1};  // the turn as a matrix: its diagonal

TEST(HalfTurn, TurnsMeans) {
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(HalfTurnSign(splat::kMean + k), kTurn[static_cast<std::size_t>(k)]);
    EXPECT_EQ(HalfTurnSign(splat::kLogScale + k), 1);
  }
  EXPECT_EQ(HalfTurnSign(splat::kOpacity), 1);
}

// The covariance's axes: the same up to their signs, which it does not depend on.
TEST(HalfTurn, TurnsRotations) {
  const std::array<double, 4> q = {0.3, -0.7, 0.5, 0.9};
  std::array<double, 4> turned;
  for (std::size_t k = 0; k < 4; ++k) turned[k] = HalfTurnSign(splat::kQuaternion + static_cast<int>(k)) * q[k];
  std::array<double, 9> R, R_turned;
  RotationFromQuaternion(q.data(), R.data());
  RotationFromQuaternion(turned.data(), R_turned.data());
  for (std::size_t column = 0; column < 3; ++column) {
    double product = 0;
    for (std::size_t row = 0; row < 3; ++row) product += kTurn[row] * R[3 * row + column] * R_turned[3 * row + column];
    EXPECT_NEAR(std::abs(product), 1, 1e-12) << column;
  }
}

// A splat that was turned shows in the turned direction the colours that it showed before.
TEST(HalfTurn, TurnsHarmonics) {
  for (const std::array<double, 3>& d :
       {std::array<double, 3>{0.48, 0.6, 0.64}, {-0.36, 0.48, -0.8}, {0, 0.6, 0.8}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
    std::array<double, kMaxShCoefficients> basis, turned;
    ShBasis<3>(d[0], d[1], d[2], basis.data());
    ShBasis<3>(d[0] * kTurn[0], d[1] * kTurn[1], d[2] * kTurn[2], turned.data());
    for (std::size_t k = 0; k < basis.size(); ++k) {
      for (int channel = 0; channel < 3; ++channel) {
        const double sign = HalfTurnSign(splat::kSh + 3 * static_cast<int>(k) + channel);
        EXPECT_NEAR(sign * turned[k], basis[k], 1e-12) << k;
      }
    }
  }
}

}  // namespace
}  // namespace vesta::gs
