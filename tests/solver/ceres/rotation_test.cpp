// SPDX-License-Identifier: Apache-2.0
// Conversions of rotations. Adapted from Ceres 2.1's test internal/ceres/rotation_test.cc.
// tests/solver/rotation_test.cpp compares every function and its derivatives with Ceres.
#include "solver/rotation.h"

#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "kernels/math/dual.h"

namespace vesta::test {
namespace {

using Eigen::Vector3d, Eigen::Vector4d;
using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr double kPi = std::numbers::pi;
constexpr double kTolerance = 1e-14;

Vector4d QuaternionOf(const Vector3d& w) {
  Vector4d q;
  AngleAxisToQuaternion(w.data(), q.data());
  EXPECT_NEAR(q.norm(), 1, kTolerance);
  return q;
}
Vector3d AngleAxisOf(const Vector4d& q) {
  Vector3d w;
  QuaternionToAngleAxis(q.data(), w.data());
  EXPECT_LE(w.norm(), kPi * (1 + 1e-15));
  return w;
}
Eigen::Matrix3d MatrixOf(const Vector3d& w) {
  Eigen::Matrix3d matrix;  // column-major
  AngleAxisToRotationMatrix(w.data(), matrix.data());
  EXPECT_LE((matrix.transpose() * matrix - Eigen::Matrix3d::Identity()).norm(), kTolerance);
  return matrix;
}
Vector3d AngleAxisOf(const Eigen::Matrix3d& matrix) {
  Vector3d w;
  RotationMatrixToAngleAxis(matrix.data(), w.data());
  return w;
}

TEST(CeresCasesRotation, OfVectorsAndQuaternions) {
  // The largest angle whose square underflows.
  const double tiny = std::pow(std::numeric_limits<double>::min(), 0.75);
  const struct {
    Vector3d w;
    Vector4d q;
  } cases[] = {{{0, 0, 0}, {1, 0, 0, 0}},           {{0.01, 0, 0}, {std::cos(0.005), std::sin(0.005), 0, 0}},
               {{tiny, 0, 0}, {1, tiny / 2, 0, 0}}, {{kPi / 2, 0, 0}, {std::sqrt(0.5), std::sqrt(0.5), 0, 0}},
               {{0, kPi, 0}, {0, 0, 1, 0}},         {{0, 0, kPi / 3}, {std::sqrt(3.0) / 2, 0, 0, 0.5}}};
  for (const auto& [w, q] : cases) {
    EXPECT_LE((QuaternionOf(w) - q).norm(), kTolerance) << w.transpose();
    EXPECT_LE((AngleAxisOf(q) - w).norm(), kTolerance) << w.transpose();
    EXPECT_NEAR(AngleAxisOf(q).norm(), w.norm(), 1e-15 * w.norm());
  }
  // 3/2 pi one way is pi / 2 the other way.
  const Vector4d far(std::cos(0.75 * kPi), std::sin(0.75 * kPi), 0, 0);
  EXPECT_LE((AngleAxisOf(far) - Vector3d(-kPi / 2, 0, 0)).norm(), kTolerance);
}

TEST(CeresCasesRotation, OfVectorsAndMatrices) {
  Eigen::Matrix3d x, y, z;
  x << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  y << -1, 0, 0, 0, 1, 0, 0, 0, -1;
  z << 0.5, -std::sqrt(3.0) / 2, 0, std::sqrt(3.0) / 2, 0.5, 0, 0, 0, 1;
  const struct {
    Vector3d w;
    Eigen::Matrix3d matrix;
  } cases[] = {{{0, 0, 0}, Eigen::Matrix3d::Identity()},
               {{1e-24, 2e-24, 3e-24}, Eigen::Matrix3d::Identity()},
               {{kPi / 2, 0, 0}, x},
               {{0, kPi, 0}, y},
               {{0, 0, kPi / 3}, z}};
  for (const auto& [w, matrix] : cases) {
    EXPECT_LE((MatrixOf(w) - matrix).norm(), kTolerance) << w.transpose();
    EXPECT_LE((AngleAxisOf(matrix) - w).norm(), kTolerance) << w.transpose();
  }
  // Half a turn about the x axis.
  const Eigen::Matrix3d half = Vector3d(1, -1, -1).asDiagonal();
  EXPECT_LE((AngleAxisOf(half) - Vector3d(kPi, 0, 0)).norm(), kTolerance);
}

TEST(CeresCasesRotation, ThereAndBack) {
  srand(5);
  for (int trial = 0; trial < 2000; ++trial) {
    const Vector3d axis = Vector3d::Random().normalized();
    const double unit = Eigen::internal::random<double>(0, 1);
    // Any angle, close to pi, and close to 0.
    for (const double angle : {kPi * unit, kPi - 1e-8 * unit, 1e-16 * unit}) {
      const Vector3d w = angle * axis;
      EXPECT_LE((AngleAxisOf(QuaternionOf(w)) - w).norm(), kTolerance) << angle;
      // At half a turn, w and -w are the same rotation.
      const Vector3d back = AngleAxisOf(MatrixOf(w));
      EXPECT_LE(std::min((back - w).norm(), angle > kPi - 1e-7 ? (back + w).norm() : 4.0), 1e-7) << angle;
      EXPECT_LE((MatrixOf(back) - MatrixOf(w)).norm(), kTolerance) << angle;
    }
    const Vector4d q = Vector4d::Random().normalized(), same = QuaternionOf(AngleAxisOf(q));
    EXPECT_LE(std::min((same - q).norm(), (same + q).norm()), kTolerance);
  }
}

TEST(CeresCasesRotation, OfANearlyHalfTurn) {
  // An example by T. Strauss in Ceres's test.
  RowMajor3 matrix;
  matrix << -0.999807135425239, -0.0128154391194470, -0.0148814136745799,  //
      -0.0128154391194470, -0.148441438622958, 0.988838158557669,          //
      -0.0148814136745799, 0.988838158557669, 0.148248574048196;
  const RowMajor3& known = matrix;
  Vector3d w;
  RotationMatrixToAngleAxis(RowMajorAdapter3x3(known.data()), w.data());
  RowMajor3 back;
  AngleAxisToRotationMatrix(w.data(), RowMajorAdapter3x3(back.data()));
  EXPECT_LE((back - matrix).norm(), 4e-14);
}

// Derivatives of both conversions at rotations by theta about x, down to the smallest numbers and 0.
TEST(CeresCasesRotation, DerivativesAtTinyAngles) {
  std::vector<double> angles = {0};
  for (int exponent = -2; exponent > -308; --exponent) angles.push_back(std::pow(10.0, exponent));
  for (const double theta : angles) {
    const double half = theta > 0 ? std::sin(theta / 2) / theta : 0.5;
    const double whole = theta > 1e-16 ? 2 * theta / std::sin(theta) : 2;
    for (int k = 0; k < 4; ++k) {
      using Scalar = Dual<double>;
      if (k < 3) {
        const Scalar w[3] = {Scalar(theta, k == 0), Scalar(0.0, k == 1), Scalar(0.0, k == 2)};
        Scalar q[4];
        AngleAxisToQuaternion(w, q);
        const double expected[4] = {k == 0 ? -std::sin(theta / 2) / 2 : 0, k == 0 ? std::cos(theta / 2) / 2 : 0,
                                    k == 1 ? half : 0, k == 2 ? half : 0};
        for (int i = 0; i < 4; ++i) EXPECT_NEAR(q[i].v, expected[i], kTolerance) << theta << ", " << k << ", " << i;
      }
      const double sine = std::sin(theta), cosine = std::cos(theta);
      const Scalar q[4] = {Scalar(cosine, k == 0), Scalar(sine, k == 1), Scalar(0.0, k == 2), Scalar(0.0, k == 3)};
      Scalar w[3];
      QuaternionToAngleAxis(q, w);
      EXPECT_NEAR(w[0].a, 2 * theta, kTolerance * theta);
      const double expected[3] = {k == 0 ? -2 * sine : k == 1 ? 2 * cosine : 0, k == 2 ? whole : 0, k == 3 ? whole : 0};
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(w[i].v, expected[i], kTolerance) << theta << ", " << k << ", " << i;
    }
  }
}

TEST(CeresCasesRotation, EulerAnglesAboutOneAxis) {
  RowMajor3 matrix;
  for (int axis = -1; axis < 3; ++axis) {
    for (const double angle : {-1.0, 1.0}) {
      const Vector3d w = axis < 0 ? Vector3d::Zero() : Vector3d(angle * Vector3d::Unit(axis));
      const Vector3d degrees = 180 / kPi * w;
      EulerAnglesToRotationMatrix(degrees.data(), 3, matrix.data());
      EXPECT_LE((matrix - MatrixOf(w)).norm(), kTolerance);
    }
  }
  srand(6);
  for (int trial = 0; trial < 100; ++trial) {
    const Vector3d degrees = 360 * Vector3d::Random();
    EulerAnglesToRotationMatrix(degrees.data(), 3, matrix.data());
    EXPECT_LE((matrix * matrix.transpose() - RowMajor3::Identity()).norm(), kTolerance);
  }
}

TEST(CeresCasesRotation, ByQuaternions) {
  // A quaternion of length 0.844 and its matrix, as in Ceres's test.
  const Vector4d q(0.1956830471754074, -0.0150618562474847, 0.7634572982788086, -0.3019454777240753);
  RowMajor3 expected, matrix;
  expected << -0.8918859164053080, 0.1335655625725649, 0.4320876677394745,  //
      -0.1981166751680096, 0.7434648665444399, -0.6387564287225856,         //
      -0.4065578619806013, -0.6553016349046693, -0.6366242786393164;
  QuaternionToRotation(q.data(), matrix.data());
  EXPECT_LE((matrix - expected).norm(), kTolerance);
  QuaternionToScaledRotation(q.data(), matrix.data());
  EXPECT_LE((matrix - q.squaredNorm() * expected).norm(), kTolerance);
  const Vector3d p(0.11, -13.15, 1.17);
  const Vector4d unit = q.normalized();
  Vector3d turned;
  UnitQuaternionRotatePoint(unit.data(), p.data(), turned.data());
  EXPECT_LE((turned - expected * p).norm(), 4e-15 * p.norm());
  QuaternionRotatePoint(q.data(), p.data(), turned.data());
  EXPECT_LE((turned - expected * p).norm(), 4e-15 * p.norm());
  // Products are associative.
  srand(7);
  const Vector4d a = Vector4d::Random(), b = Vector4d::Random(), c = Vector4d::Random();
  Vector4d ab, bc, ab_c, a_bc;
  QuaternionProduct(a.data(), b.data(), ab.data()), QuaternionProduct(ab.data(), c.data(), ab_c.data());
  QuaternionProduct(b.data(), c.data(), bc.data()), QuaternionProduct(a.data(), bc.data(), a_bc.data());
  EXPECT_LE((ab_c - a_bc).norm(), kTolerance);
}

TEST(CeresCasesRotation, PointsTurnByVectorAsByMatrix) {
  srand(8);
  for (int trial = 0; trial < 2000; ++trial) {
    for (const double scale : {1.0, 1e-16}) {
      const Vector3d w = scale * 7 * Vector3d::Random(), p = Vector3d::Random();
      Vector3d turned;
      AngleAxisRotatePoint(w.data(), p.data(), turned.data());
      EXPECT_LE((turned - MatrixOf(w) * p).norm(), kTolerance);
    }
  }
}

TEST(CeresCasesRotation, AdaptersReadRowsAndColumns) {
  double values[9] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(RowMajorAdapter3x3(values)(i, k), values[3 * i + k]);
      EXPECT_EQ(ColumnMajorAdapter3x3(values)(i, k), values[3 * k + i]);
    }
  }
  float two_by_four[8];
  const MatrixAdapter<float, 4, 1> rows(two_by_four);
  for (int i = 0; i < 8; ++i) rows(i / 4, i % 4) = static_cast<float>(i);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(two_by_four[i], static_cast<float>(i));
}

// Ceres's own functions take dual numbers, also in a file that includes both headers.
TEST(CeresCasesRotation, CeressFunctionsTakeDualNumbers) {
  using Scalar = Dual<double>;
  const Scalar w[3] = {Scalar(0.3, 1.0), Scalar(-0.2), Scalar(0.5)}, p[3] = {Scalar(1.0), Scalar(2.0), Scalar(3.0)};
  Scalar ours[9], theirs[9], back[3];
  const auto expect_same = [&](int size) {
    for (int i = 0; i < size; ++i) {
      EXPECT_NEAR(theirs[i].a, ours[i].a, kTolerance);
      EXPECT_NEAR(theirs[i].v, ours[i].v, kTolerance);
    }
  };
  AngleAxisRotatePoint(w, p, ours), ceres::AngleAxisRotatePoint(w, p, theirs);
  expect_same(3);
  AngleAxisToRotationMatrix(w, ours), ceres::AngleAxisToRotationMatrix(w, theirs);
  expect_same(9);
  ceres::RotationMatrixToAngleAxis(theirs, back);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(back[i].v, w[i].v, kTolerance);
  AngleAxisToQuaternion(w, ours), ceres::AngleAxisToQuaternion(w, theirs);
  expect_same(4);
  Scalar turned[3];
  ceres::QuaternionRotatePoint(theirs, p, turned);
  AngleAxisRotatePoint(w, p, ours);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(turned[i].v, ours[i].v, kTolerance);
}

}  // namespace
}  // namespace vesta::test
