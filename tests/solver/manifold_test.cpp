// SPDX-License-Identifier: Apache-2.0
#include "solver/manifold.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"
#include "solver/autodiff_manifold.h"
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
    Check(LineManifold(3), Eigen::VectorXd::Random(6));
    Check(LineManifold(2), Eigen::VectorXd::Random(4));
    Check(EuclideanManifold(3), Eigen::Vector3d::Random());
    Check(SubsetManifold(4, {2, 0}), Eigen::Vector4d::Random());
    Eigen::VectorXd pose(7);
    pose << q, Eigen::Vector3d::Random();
    Check(Se3Manifold(QuaternionManifold::Order::kWxyz), pose);
    Check(Se3Manifold(QuaternionManifold::Order::kXyzw), pose);
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

TEST(Manifold, LinesMoveAsCeressDo) {
  srand(11);
  for (const int size : {2, 3, 5}) {
    const LineManifold ours(size);
    const ceres::LineManifold<ceres::DYNAMIC> theirs(size);
    for (const double scale : {0.0, 1e-9, 1e-3, 1.0}) {
      Eigen::VectorXd x = 3 * Eigen::VectorXd::Random(2 * size), expected(2 * size);
      const Eigen::VectorXd delta = scale * Eigen::VectorXd::Random(2 * (size - 1)), scaled = kCeresPerAngle * delta;
      ASSERT_TRUE(theirs.Plus(x.data(), scaled.data(), expected.data()));
      const Eigen::VectorXd moved = Plus(ours, x, delta);
      EXPECT_LE((moved - expected).norm(), 1e-14) << size << " " << scale;
      EXPECT_NEAR(moved.tail(size).norm(), x.tail(size).norm(), 1e-14);
      EXPECT_NEAR((moved - x).head(size).dot(x.tail(size)), 0, 1e-14) << "perpendicular to the line";
      // Ceres's Jacobian agrees with its Plus only for directions of length 1.
      x.tail(size).normalize();
      RowMajor jacobian(2 * size, 2 * (size - 1));
      ASSERT_TRUE(theirs.PlusJacobian(x.data(), jacobian.data()));
      EXPECT_LE((PlusJacobian(ours, x) - kCeresPerAngle * jacobian).norm(), 1e-13) << size;
    }
  }
}

// The matrix of a pose [q; t] with q in the order w x y z.
Eigen::Matrix4d MatrixOf(const Eigen::VectorXd& pose) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = Eigen::Quaterniond(pose[0], pose[1], pose[2], pose[3]).toRotationMatrix();
  matrix.topRightCorner<3, 1>() = pose.tail<3>();
  return matrix;
}
// The exponential of a twist [rho; phi], by scaling and squaring.
Eigen::Matrix4d Exponential(const Eigen::VectorXd& twist) {
  Eigen::Matrix4d generator = Eigen::Matrix4d::Zero();
  const Eigen::Vector3d phi = twist.tail<3>();
  generator.topLeftCorner<3, 3>() << 0, -phi[2], phi[1], phi[2], 0, -phi[0], -phi[1], phi[0], 0;
  generator.topRightCorner<3, 1>() = twist.head<3>();
  generator /= 64;
  Eigen::Matrix4d sum = Eigen::Matrix4d::Identity(), power = sum;
  for (int k = 1; k < 20; ++k) {
    power = (power * generator / k).eval();
    sum += power;
  }
  for (int k = 0; k < 6; ++k) sum = (sum * sum).eval();
  return sum;
}

TEST(Manifold, PosesMoveByExponentials) {
  srand(12);
  for (const double scale : {0.0, 1e-160, 1e-9, 1e-4, 0.3, 1.0, 3.0}) {
    Eigen::VectorXd pose(7), swapped(7);
    pose << Eigen::Vector4d::Random().normalized(), 2 * Eigen::Vector3d::Random();
    const Eigen::VectorXd delta = scale * Eigen::VectorXd::Random(6);
    const Eigen::VectorXd moved = Plus(Se3Manifold(), pose, delta);
    EXPECT_LE((MatrixOf(moved) - MatrixOf(pose) * Exponential(delta)).norm(), 3e-14) << scale;
    swapped << pose.segment(1, 3), pose[0], pose.tail(3);
    const Eigen::VectorXd other = Plus(Se3Manifold(QuaternionManifold::Order::kXyzw), swapped, delta);
    EXPECT_EQ(other.head(3), moved.segment(1, 3));
    EXPECT_EQ(other[3], moved[0]);
    EXPECT_EQ(other.tail(3), moved.tail(3));
  }
}

// Vectors of constant length in the plane. From x_0 >= 2 there is no step.
struct Circle {
  template <class T>
  bool Plus(const T* x, const T* delta, T* out) const {
    using std::cos;
    using std::sin;
    const T c = cos(delta[0]), s = sin(delta[0]);
    out[0] = c * x[0] - s * x[1];
    out[1] = s * x[0] + c * x[1];
    return x[0] < T(2.0);
  }
};
// The translation of R^2, whose functor returns nothing and leaves a number unwritten for large steps.
struct Forgetful {
  template <class T>
  void Plus(const T* x, const T* delta, T* out) const {
    out[0] = x[0] + delta[0];
    if (delta[1] < T(100.0)) out[1] = x[1] + delta[1];
  }
};

TEST(Manifold, FunctorsAreDifferentiated) {
  const AutoDiffManifold<Circle, 2, 1> circle;
  Check(circle, Eigen::Vector2d(0.6, -0.8));
  EXPECT_FALSE(Plus(circle, Eigen::Vector2d(2, 0), Eigen::VectorXd::Ones(1)).allFinite());
  const AutoDiffManifold<Forgetful, 2, 2> forgetful;
  EXPECT_EQ(PlusJacobian(forgetful, Eigen::Vector2d(1, 2)), Eigen::Matrix2d::Identity());
  EXPECT_EQ(Plus(forgetful, Eigen::Vector2d(1, 2), Eigen::Vector2d(3, 4)), Eigen::Vector2d(4, 6));
  EXPECT_TRUE(std::isnan(Plus(forgetful, Eigen::Vector2d(1, 2), Eigen::Vector2d(0, 100))[1]));
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
  EXPECT_THROW(LineManifold(1), Error);
  EXPECT_THROW(EuclideanManifold(0), Error);
  EXPECT_THROW(SubsetManifold(3, {3}), Error);
  EXPECT_THROW(SubsetManifold(3, {1, 1}), Error);
  EXPECT_THROW(SubsetManifold(2, {0, 1}), Error);
}

}  // namespace
}  // namespace vesta
