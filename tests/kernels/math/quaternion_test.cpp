// SPDX-License-Identifier: Apache-2.0
#include "kernels/math/quaternion.h"

#include <ceres/jet.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/random.h"

namespace vesta {
namespace {

using Jet = ceres::Jet<double, 4>;

class Quaternion : public testing::TestWithParam<double> {};

TEST_P(Quaternion, RotationAgreesWithCeres) {
  test::Random random(3);
  for (int trial = 0; trial < 50; ++trial) {
    double q[4], R[9], expected[9];
    for (double& value : q) value = GetParam() * random.Normal();
    RotationFromQuaternion(q, R);
    ceres::QuaternionToRotation(q, ceres::RowMajorAdapter3x3(expected));
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(R[i], expected[i], 1e-14);
  }
}

TEST_P(Quaternion, AdjointAgreesWithJetsThroughNormalisation) {
  test::Random random(4);
  for (int trial = 0; trial < 50; ++trial) {
    double q[4], R_bar[9], q_bar[4];
    Jet jets[4], R[9];
    for (int i = 0; i < 4; ++i) q[i] = GetParam() * random.Normal(), jets[i] = Jet(q[i], i);
    for (double& value : R_bar) value = random.Normal();
    RotationFromQuaternionAdjoint(q, R_bar, q_bar);
    ceres::QuaternionToRotation(jets, ceres::RowMajorAdapter3x3(R));
    double expected[4] = {}, scale = 0, along = 0;
    for (int i = 0; i < 4; ++i) {
      for (int k = 0; k < 9; ++k) expected[i] += R_bar[k] * R[k].v[i];
      scale = std::max(scale, std::abs(expected[i]));
      along += q[i] * q_bar[i];
    }
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(q_bar[i], expected[i], 1e-12 * scale);
    EXPECT_NEAR(along, 0, 1e-12 * scale * GetParam());
  }
}

INSTANTIATE_TEST_SUITE_P(Lengths, Quaternion, testing::Values(1e-6, 0.1, 1.0, 30.0, 1e6));

TEST(Quaternion, WithoutDirectionIsTheIdentityAndDoesNotMove) {
  const double q[4] = {0, 1e-13, 0, 0}, R_bar[9] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  double R[9], q_bar[4];
  RotationFromQuaternion(q, R);
  RotationFromQuaternionAdjoint(q, R_bar, q_bar);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(R[i], i % 4 == 0 ? 1 : 0);
  for (const double value : q_bar) EXPECT_EQ(value, 0);
}

TEST(Quaternion, ExponentialIsTheRotationByTwiceTheVector) {
  test::Random random(5);
  for (const double size : {0.0, 1e-9, 1e-3, 0.0099, 0.0101, 0.5, 3.0}) {
    double d[3], angle_axis[3], q[4], expected[4];
    for (int i = 0; i < 3; ++i) d[i] = size * random.Normal(), angle_axis[i] = 2 * d[i];
    QuaternionExponential(d, q);
    ceres::AngleAxisToQuaternion(angle_axis, expected);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(q[i], expected[i], 1e-15) << size;
  }
}

TEST(Quaternion, ProductIsOneRotationAfterTheOther) {
  test::Random random(6);
  double a[4], b[4], ab[4], inverse[4], expected[4];
  for (double& value : a) value = random.Normal();
  for (double& value : b) value = random.Normal();
  QuaternionProduct(a, b, ab);
  ceres::QuaternionProduct(a, b, expected);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(ab[i], expected[i], 1e-15);
  NormalizeQuaternion(ab, ab);
  QuaternionConjugate(ab, inverse);
  QuaternionProduct(ab, inverse, expected);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(expected[i], i == 0 ? 1 : 0, 1e-15);
}

TEST(Quaternion, RoundTripsThroughItsRotation) {
  test::Random random(7);
  for (int k = 0; k < 40; ++k) {
    double q[4], R[9], back[4];
    for (double& value : q) value = random.Normal();
    // Includes the identity and half turns, where components are zero.
    if (k < 8) std::fill(q, q + 4, 0.0), q[k % 4] = 1;
    NormalizeQuaternion(q, q);
    RotationFromQuaternion(q, R);
    QuaternionFromRotation(R, back);
    const double sign = q[0] * back[0] + q[1] * back[1] + q[2] * back[2] + q[3] * back[3] < 0 ? -1 : 1;
    EXPECT_GE(back[0], 0);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(back[i], sign * q[i], 1e-15);
  }
}

}  // namespace
}  // namespace vesta
