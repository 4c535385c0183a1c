// SPDX-License-Identifier: Apache-2.0
#include "solver/manifold.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Eigen::VectorXd Plus(const Manifold& manifold, const Eigen::VectorXd& x, const Eigen::VectorXd& delta) {
  Eigen::VectorXd out(manifold.ambient_size());
  manifold.Plus(x.data(), delta.data(), out.data());
  return out;
}

RowMajor PlusJacobian(const Manifold& manifold, const Eigen::VectorXd& x) {
  RowMajor jacobian(manifold.ambient_size(), manifold.tangent_size());
  manifold.PlusJacobian(x.data(), jacobian.data());
  return jacobian;
}

// Properties of every manifold at one x: Plus(x, 0) = x, Plus works in place, and the Jacobian agrees with differences.
void Check(const Manifold& manifold, const Eigen::VectorXd& x) {
  ASSERT_EQ(x.size(), manifold.ambient_size());
  const int n = manifold.tangent_size();
  EXPECT_EQ((Plus(manifold, x, Eigen::VectorXd::Zero(n)) - x).norm(), 0);
  Eigen::VectorXd delta = Eigen::VectorXd::Random(n), in_place = x;
  manifold.Plus(in_place.data(), delta.data(), in_place.data());
  EXPECT_EQ((in_place - Plus(manifold, x, delta)).norm(), 0);
  const RowMajor jacobian = PlusJacobian(manifold, x);
  const double h = 1e-5;
  for (int k = 0; k < n; ++k) {
    const Eigen::VectorXd step = h * Eigen::VectorXd::Unit(n, k);
    const Eigen::VectorXd slope = (Plus(manifold, x, step) - Plus(manifold, x, -step)) / (2 * h);
    EXPECT_LE((slope - jacobian.col(k)).norm(), 1e-9 * (1 + x.norm())) << "column " << k;
  }
}

TEST(Manifold, PlusAndItsJacobian) {
  srand(7);
  for (int trial = 0; trial < 5; ++trial) {
    const Eigen::Vector4d q = Eigen::Vector4d::Random().normalized();
    Check(QuaternionManifold(QuaternionManifold::Order::kWxyz), q);
    Check(QuaternionManifold(QuaternionManifold::Order::kXyzw), q);
    Check(UnitVectorManifold(3), 2.5 * Eigen::Vector3d::Random());
    Check(UnitVectorManifold(2), Eigen::Vector2d::Random());
    Check(UnitVectorManifold(5), Eigen::VectorXd::Random(5));
    Check(EuclideanManifold(3), Eigen::Vector3d::Random());
    Check(SubsetManifold(4, {2, 0}), Eigen::Vector4d::Random());
    Eigen::VectorXd pose(7);
    pose << q, Eigen::Vector3d::Random();
    Check(ProductManifold({std::make_shared<QuaternionManifold>(), std::make_shared<EuclideanManifold>(3)}), pose);
  }
  // Both ends of the reflection's own axis.
  Check(UnitVectorManifold(3), Eigen::Vector3d(0, 0, 1));
  Check(UnitVectorManifold(3), Eigen::Vector3d(0, 0, -1));
}

TEST(Manifold, QuaternionsTurnAsCeressDo) {
  srand(8);
  const ceres::QuaternionManifold wxyz;
  const ceres::EigenQuaternionManifold xyzw;
  for (const auto& [ours, theirs] : std::initializer_list<std::pair<QuaternionManifold, const ceres::Manifold*>>{
           {QuaternionManifold(QuaternionManifold::Order::kWxyz), &wxyz},
           {QuaternionManifold(QuaternionManifold::Order::kXyzw), &xyzw}}) {
    for (const double scale : {1e-12, 1e-3, 1.0, 4.0}) {
      const Eigen::Vector4d q = Eigen::Vector4d::Random().normalized();
      const Eigen::Vector3d delta = scale * Eigen::Vector3d::Random();
      Eigen::Vector4d expected;
      ASSERT_TRUE(theirs->Plus(q.data(), delta.data(), expected.data()));
      EXPECT_LE((Plus(ours, q, delta) - expected).norm(), 1e-15 * 4);
      RowMajor jacobian(4, 3);
      ASSERT_TRUE(theirs->PlusJacobian(q.data(), jacobian.data()));
      EXPECT_LE((PlusJacobian(ours, q) - jacobian).norm(), 1e-15 * 4);
    }
  }
}

// Ceres 2.2 measures delta by the angle on the sphere, Ceres 2.1 by twice the angle.
constexpr double kCeresPerAngle = CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR < 2 ? 2 : 1;

TEST(Manifold, UnitVectorsTurnAsCeressSphereDoes) {
  srand(10);
  for (const int size : {2, 3, 4, 7}) {
    const UnitVectorManifold ours(size);
    const ceres::SphereManifold<ceres::DYNAMIC> theirs(size);
    for (const double scale : {1e-12, 1e-3, 1.0, 4.0}) {
      for (const double sign : {-1.0, 1.0}) {
        Eigen::VectorXd x = 3 * Eigen::VectorXd::Random(size);
        x[size - 1] = sign * std::abs(x[size - 1]);
        const Eigen::VectorXd delta = scale * Eigen::VectorXd::Random(size - 1), scaled = kCeresPerAngle * delta;
        Eigen::VectorXd expected(size);
        ASSERT_TRUE(theirs.Plus(x.data(), scaled.data(), expected.data()));
        EXPECT_LE((Plus(ours, x, delta) - expected).norm(), 1e-14) << size << " " << scale << " " << sign;
        RowMajor jacobian(size, size - 1);
        ASSERT_TRUE(theirs.PlusJacobian(x.data(), jacobian.data()));
        EXPECT_LE((PlusJacobian(ours, x) - kCeresPerAngle * jacobian).norm(), 1e-13) << size << " " << sign;
        // |delta| is the angle.
        if (delta.norm() < 3) {
          const double cosine = std::clamp(x.dot(Plus(ours, x, delta)) / x.squaredNorm(), -1.0, 1.0);
          EXPECT_NEAR(std::acos(cosine), delta.norm(), 1e-7);
        }
      }
    }
  }
}

TEST(Manifold, UnitVectorsNearTheAxisOfTheReflection) {
  for (const double sign : {-1.0, 1.0}) {
    for (const double off : {1e-3, 1e-7, 1e-9, 1e-15, 1e-100, 1e-200}) {
      const Eigen::Vector3d x(3 * off, -4 * off, sign * 2);
      const Eigen::Vector2d delta(0.3, 0.2);
      EXPECT_LE((Plus(UnitVectorManifold(3), x, 1e-300 * delta) - x).norm(), 1e-15) << off;
      Check(UnitVectorManifold(3), x);
    }
  }
}

TEST(Manifold, UnitVectorsKeepTheirLength) {
  srand(9);
  const UnitVectorManifold manifold(4);
  Eigen::VectorXd x = 3 * Eigen::Vector4d::Random();
  const double length = x.norm();
  for (int step = 0; step < 100; ++step) x = Plus(manifold, x, Eigen::Vector3d::Random());
  EXPECT_NEAR(x.norm(), length, 1e-13 * length);
}

TEST(Manifold, AProductNamesItsNullPart) {
  EXPECT_THAT(
      [] {
        ProductManifold({std::make_shared<EuclideanManifold>(3), nullptr});
      },
      ThrowsError(kBadArgument, "1"));
}

TEST(Manifold, RefusesSizesThatAreNone) {
  EXPECT_THROW(UnitVectorManifold(1), Error);
  EXPECT_THROW(EuclideanManifold(0), Error);
  EXPECT_THROW(SubsetManifold(3, {3}), Error);
  EXPECT_THROW(SubsetManifold(3, {1, 1}), Error);
  EXPECT_THROW(SubsetManifold(2, {0, 1}), Error);
}

}  // namespace
}  // namespace vesta
