// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/spz_rotation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstring>

#include "kernels/math/quaternion.h"

namespace vesta::gs {
namespace {

std::array<double, 9> RotationOf(const std::array<double, 4>& q) {
  std::array<double, 9> R{};
  RotationFromQuaternion(q.data(), R.data());
  return R;
}

TEST(CubeTurns, AreAllDifferent) {
  const auto& turns = CubeTurns();
  EXPECT_EQ(turns[0].quaternion, (std::array<double, 4>{1, 0, 0, 0}));
  EXPECT_EQ(turns[0].axes, (std::array<int, 3>{0, 1, 2}));
  for (const CubeTurn& turn : turns) {
    for (const CubeTurn& other : turns) {
      double product = 0;
      for (std::size_t k = 0; k < 4; ++k) product += turn.quaternion[k] * other.quaternion[k];
      EXPECT_TRUE(&turn == &other ? std::abs(product - 1) < 1e-12 : std::abs(product) < 0.9);
    }
  }
}

TEST(CubeTurns, LeaveTheCovariance) {
  const std::array<double, 4> q = {0.3, -0.7, 0.5, 0.9};
  const std::array<double, 3> variances = {1, 4, 9};
  const auto covariance = [](const std::array<double, 9>& R, const std::array<double, 3>& v) {
    std::array<double, 9> C{};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t k = 0; k < 3; ++k) C[3 * i + j] += R[3 * i + k] * v[k] * R[3 * j + k];
      }
    }
    return C;
  };
  const auto expected = covariance(RotationOf(q), variances);
  for (const CubeTurn& turn : CubeTurns()) {
    std::array<double, 3> moved{};
    for (std::size_t k = 0; k < 3; ++k) moved[k] = variances[static_cast<std::size_t>(turn.axes[k])];
    const auto again = covariance(RotationOf(Product(q, turn.quaternion)), moved);
    for (std::size_t k = 0; k < 9; ++k) EXPECT_NEAR(again[k], expected[k], 1e-12);
  }
}

TEST(QuaternionProduct, IsThatOfTheRotations) {
  const std::array<double, 4> p = {0.1, 0.2, -0.5, 0.4}, q = {0.3, -0.7, 0.5, 0.9};
  const auto P = RotationOf(p), Q = RotationOf(q), R = RotationOf(Product(p, q));
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k) sum += P[3 * i + k] * Q[3 * k + j];
      EXPECT_NEAR(R[3 * i + j], sum, 1e-12);
    }
  }
}

// The numbers x, y, z and w, times 511 sqrt(2), fill the bits after the index of the largest.
TEST(SpzRotation, BitsOfFourBytes) {
  const auto word_of = [](const std::array<double, 4>& wxyz) {
    std::array<std::uint8_t, 4> bytes{};
    EXPECT_EQ(WriteSpzRotation(3, wxyz, bytes.data()), (std::array<int, 3>{0, 1, 2}));
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data(), 4);
    return word;
  };
  EXPECT_EQ(word_of({2, 0, 0, 0}), 3u << 30);
  EXPECT_EQ(word_of({0, -5, 0, 0}), 0u);
  // 0.5 sqrt(2) 511 is 361.3. The largest number is negative, so all change sign.
  EXPECT_EQ(word_of({0.5, 0.5, -0.70710678, 0}), 1u << 30 | (512u + 361) << 20 | (512u + 361));
  EXPECT_EQ(word_of({1, 0, 0, 1 - 1e-9}), 3u << 30 | 511u);
}

}  // namespace
}  // namespace vesta::gs
