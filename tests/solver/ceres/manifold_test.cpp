// SPDX-License-Identifier: Apache-2.0
// Manifolds. Adapted from Ceres 2.1's tests manifold_test.cc and autodiff_manifold_test.cc in internal/ceres;
// docs/ceres_tests.md lists the omitted cases. Ceres's manifolds compute the expected values. Spheres and lines step as
// in Ceres 2.2, twice as far as in 2.1.
#include "solver/manifold.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "solver/autodiff_manifold.h"
#include "solver/rotation.h"
#include "tests/support/throws_error.h"

namespace vesta::test {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Eigen::VectorXd PlusOf(const Manifold& manifold, const Eigen::VectorXd& x, const Eigen::VectorXd& delta) {
  Eigen::VectorXd out = Eigen::VectorXd::Constant(manifold.ambient_size(), -1e5);
  manifold.Plus(x.data(), delta.data(), out.data());
  return out;
}

// Plus and its Jacobian agree with Ceres's manifold at random points. unit: the points have length 1.
void ExpectSameManifold(const Manifold& ours, const ceres::Manifold& theirs, bool unit = false, double scale = 1) {
  ASSERT_EQ(ours.ambient_size(), theirs.AmbientSize());
  ASSERT_EQ(ours.tangent_size(), theirs.TangentSize());
  for (int trial = 0; trial < 100; ++trial) {
    Eigen::VectorXd x = Eigen::VectorXd::Random(ours.ambient_size()), expected(ours.ambient_size());
    if (unit) x.normalize();
    Eigen::VectorXd delta = Eigen::VectorXd::Random(ours.tangent_size());
    if (scale != 1) delta *= scale / delta.norm();
    ASSERT_TRUE(theirs.Plus(x.data(), delta.data(), expected.data()));
    EXPECT_LE((PlusOf(ours, x, delta) - expected).norm(), 1e-15 * 4 * expected.norm());
    RowMajor jacobian = RowMajor::Constant(ours.ambient_size(), ours.tangent_size(), -1e5), their_jacobian = jacobian;
    ASSERT_TRUE(theirs.PlusJacobian(x.data(), their_jacobian.data()));
    ours.PlusJacobian(x.data(), jacobian.data());
    EXPECT_LE((jacobian - their_jacobian).norm(), 1e-15 * 4 * their_jacobian.norm());
  }
}

TEST(CeresCasesManifold, Euclidean) {
  srand(1);
  ExpectSameManifold(EuclideanManifold(3), ceres::EuclideanManifold<3>());
  ExpectSameManifold(EuclideanManifold(3), ceres::EuclideanManifold<ceres::DYNAMIC>(3));
}

TEST(CeresCasesManifold, Subset) {
  srand(2);
  ExpectSameManifold(SubsetManifold(3, {}), ceres::SubsetManifold(3, {}));
  for (int k = 0; k < 4; ++k) ExpectSameManifold(SubsetManifold(4, {k}), ceres::SubsetManifold(4, {k}));
  ExpectSameManifold(SubsetManifold(4, {3, 0}), ceres::SubsetManifold(4, {3, 0}));
  EXPECT_THAT([] { SubsetManifold(2, {-1}); }, ThrowsError(kBadArgument, "-1"));
  EXPECT_THAT([] { SubsetManifold(2, {2}); }, ThrowsError(kBadArgument, "2"));
  EXPECT_THAT([] { SubsetManifold(2, {1, 1}); }, ThrowsError(kBadArgument));
}

TEST(CeresCasesManifold, Product) {
  srand(3);
  using ceres::ProductManifold;
  using Theirs = ceres::SubsetManifold;
  const auto subset = [](int size, const std::vector<int>& constant) {
    return std::make_shared<SubsetManifold>(size, constant);
  };
  const auto a = subset(5, {2}), b = subset(3, {0, 1}), c = subset(4, {1}), d = subset(2, {0});
  const Theirs ta(5, {2}), tb(3, {0, 1}), tc(4, {1}), td(2, {0});
  ExpectSameManifold(vesta::ProductManifold({a, b}), ProductManifold<Theirs, Theirs>(ta, tb));
  ExpectSameManifold(vesta::ProductManifold({a, b, c}), ProductManifold<Theirs, Theirs, Theirs>(ta, tb, tc));
  ExpectSameManifold(vesta::ProductManifold({a, b, c, d}),
                     ProductManifold<Theirs, Theirs, Theirs, Theirs>(ta, tb, tc, td));
  const auto quaternion = std::make_shared<QuaternionManifold>();
  const auto euclidean = std::make_shared<EuclideanManifold>(3);
  ExpectSameManifold(vesta::ProductManifold({quaternion, euclidean}),
                     ProductManifold<ceres::QuaternionManifold, ceres::EuclideanManifold<3>>(), true);
  ExpectSameManifold(
      vesta::ProductManifold({euclidean, quaternion, euclidean}),
      ProductManifold<ceres::EuclideanManifold<3>, ceres::QuaternionManifold, ceres::EuclideanManifold<3>>(), true);
}

TEST(CeresCasesManifold, Quaternions) {
  srand(4);
  using Order = QuaternionManifold::Order;
  // Generic steps, short steps, and half a turn.
  for (const double scale : {1.0, 1e-6, std::numbers::pi - 1e-6}) {
    ExpectSameManifold(QuaternionManifold(Order::kWxyz), ceres::QuaternionManifold(), true, scale);
    ExpectSameManifold(QuaternionManifold(Order::kXyzw), ceres::EigenQuaternionManifold(), true, scale);
  }
  // A step of pi / 2 along an axis is half a turn.
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::VectorXd half = PlusOf(QuaternionManifold(Order::kWxyz), Eigen::Vector4d(1, 0, 0, 0),
                                        std::numbers::pi / 2 * Eigen::Vector3d::Unit(axis));
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(half[k], k == axis + 1 ? 1 : 0, 2e-16);
  }
  // Products of rotations. The angle is twice the length of the step.
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector4d x = Eigen::Vector4d::Random().normalized();
    const Eigen::Vector3d delta = Eigen::Vector3d::Random(), rotation = 2 * delta;
    Eigen::Vector4d turn, expected;
    ceres::AngleAxisToQuaternion(rotation.data(), turn.data());
    ceres::QuaternionProduct(turn.data(), x.data(), expected.data());
    EXPECT_LE((PlusOf(QuaternionManifold(Order::kWxyz), x, delta) - expected).norm(), 1e-15 * 2);
  }
}

// Steps from the last unit vector. The length of a step is the angle.
TEST(CeresCasesManifold, StepsOnSpheres) {
  using Eigen::Vector2d, Eigen::Vector3d;
  constexpr double kPi = std::numbers::pi;
  const double root = std::sqrt(0.5);
  const Vector2d north2(0, 1);
  for (const auto& [delta, expected] : {std::pair(kPi / 4, Vector2d(root, root)), std::pair(kPi / 2, Vector2d(1, 0)),
                                        std::pair(kPi, Vector2d(0, -1)), std::pair(2 * kPi, Vector2d(0, 1))}) {
    EXPECT_LE((PlusOf(UnitVectorManifold(2), north2, Eigen::VectorXd::Constant(1, delta)) - expected).norm(), 1e-15);
  }
  const Vector3d north(0, 0, 1);
  const Vector2d diagonal(root, root);
  for (const auto& [delta, expected] :
       {std::pair(Vector2d(kPi / 2, 0), Vector3d(1, 0, 0)), std::pair(Vector2d(kPi, 0), Vector3d(0, 0, -1)),
        std::pair(Vector2d(2 * kPi, 0), Vector3d(0, 0, 1)), std::pair(Vector2d(0, kPi / 2), Vector3d(0, 1, 0)),
        std::pair(Vector2d(0, kPi), Vector3d(0, 0, -1)), std::pair(Vector2d(0, 2 * kPi), Vector3d(0, 0, 1)),
        std::pair(Vector2d(kPi / 2 * diagonal), Vector3d(root, root, 0)),
        std::pair(Vector2d(kPi * diagonal), Vector3d(0, 0, -1))}) {
    EXPECT_LE((PlusOf(UnitVectorManifold(3), north, delta) - expected).norm(), 1e-15);
  }
  EXPECT_THAT([] { UnitVectorManifold(1); }, ThrowsError(kBadArgument, "1"));
}

// The Jacobian is the derivative of Plus at 0, and Plus(x, 0) = x.
void ExpectPlusJacobian(const Manifold& manifold, const Eigen::VectorXd& x) {
  const int n = manifold.ambient_size(), m = manifold.tangent_size();
  EXPECT_LE((PlusOf(manifold, x, Eigen::VectorXd::Zero(m)) - x).norm(), 1e-15 * 4 * x.norm());
  RowMajor jacobian = RowMajor::Constant(n, m, -1e5);
  manifold.PlusJacobian(x.data(), jacobian.data());
  constexpr double kStep = 1e-6;
  for (int k = 0; k < m; ++k) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(m, k);
    const Eigen::VectorXd slope = (PlusOf(manifold, x, step) - PlusOf(manifold, x, -step)) / (2 * kStep);
    EXPECT_LE((jacobian.col(k) - slope).norm(), 1e-9 * (1 + x.norm()));
  }
}

// The length of x stays, and the length of delta is the angle.
void ExpectSphere(const Eigen::VectorXd& x, const Eigen::VectorXd& delta) {
  const UnitVectorManifold manifold(static_cast<int>(x.size()));
  const Eigen::VectorXd y = PlusOf(manifold, x, delta);
  EXPECT_NEAR(y.norm(), x.norm(), 1e-15 * 4 * x.norm());
  EXPECT_NEAR(y.dot(x) / x.squaredNorm(), std::cos(delta.norm()), 1e-14);
  ExpectPlusJacobian(manifold, x);
}

TEST(CeresCasesManifold, InvariantsOfSpheres) {
  srand(5);
  ExpectSphere(Eigen::Vector4d(0, 0, 0, 1), Eigen::Vector3d::Zero());
  ExpectSphere(Eigen::Vector4d(1e-5, 1e-5, 1e-5, 1).normalized(), Eigen::Vector3d(0, 1, 0));
  ExpectSphere(Eigen::Vector4d(0.01, 0, 0, 0), Eigen::Vector3d(0, 1, 0));
  for (int trial = 0; trial < 100; ++trial) {
    ExpectSphere(Eigen::VectorXd::Random(4), Eigen::VectorXd::Random(3));
    ExpectSphere(Eigen::VectorXd::Random(5), Eigen::VectorXd::Random(4));
  }
}

// Lines from the origin along the last axis: the step has the shift of the point, then that of the direction.
TEST(CeresCasesManifold, StepsOnLines) {
  constexpr double kHalf = std::numbers::pi / 2;
  const double root = std::sqrt(0.5);
  const LineManifold manifold(3);
  const Eigen::VectorXd x = Eigen::VectorXd::Unit(6, 5);
  Eigen::MatrixXd deltas(3, 4), expected(3, 6);
  deltas << 0, 2, kHalf, 0, 3, 0, 0, kHalf, 1, 2, root * kHalf, root * kHalf;
  expected << 0, 2, 0, 1, 0, 0, 3, 0, 0, 0, 1, 0, 1, 2, 0, root, root, 0;
  for (int i = 0; i < 3; ++i) {
    EXPECT_LE((PlusOf(manifold, x, deltas.row(i).transpose()) - expected.row(i).transpose()).norm(), 4e-15);
  }
}

// The direction stays of length 1, the point moves at a right angle to the direction.
void ExpectLine(int n, const Eigen::VectorXd& x, const Eigen::VectorXd& delta) {
  const LineManifold manifold(n);
  ASSERT_EQ(manifold.ambient_size(), 2 * n);
  ASSERT_EQ(manifold.tangent_size(), 2 * n - 2);
  const Eigen::VectorXd y = PlusOf(manifold, x, delta);
  EXPECT_NEAR(y.tail(n).norm(), 1, 4e-15);
  EXPECT_NEAR((y - x).head(n).dot(x.tail(n)), 0, 1e-14);
  EXPECT_NEAR((y - x).head(n).norm(), delta.head(n - 1).norm(), 1e-14);
  EXPECT_NEAR(y.tail(n).dot(x.tail(n)), std::cos(delta.tail(n - 1).norm()), 1e-14);
  ExpectPlusJacobian(manifold, x);
}

TEST(CeresCasesManifold, InvariantsOfLines) {
  srand(6);
  for (const int n : {3, 4}) {
    const Eigen::VectorXd axis = Eigen::VectorXd::Unit(2 * n, 2 * n - 1);
    Eigen::VectorXd move = Eigen::VectorXd::Zero(2 * n - 2), turn = move;
    move.head(n - 1).setLinSpaced(3, 1), turn.tail(n - 1).setLinSpaced(0.5, 1.5);
    ExpectLine(n, axis, Eigen::VectorXd::Zero(2 * n - 2));
    ExpectLine(n, axis, move);
    ExpectLine(n, axis, turn);
    for (int trial = 0; trial < 50; ++trial) {
      Eigen::VectorXd x = Eigen::VectorXd::Random(2 * n);
      x.tail(n).normalize();
      ExpectLine(n, x, Eigen::VectorXd::Random(2 * n - 2));
    }
  }
}

// x + s delta.
struct Scaled {
  double s = 1;
  template <class T>
  bool Plus(const T* x, const T* delta, T* out) const {
    for (int i = 0; i < 3; ++i) out[i] = x[i] + T(s) * delta[i];
    return true;
  }
};
// A turn by twice delta, which needs a series at 0.
struct Turn {
  template <class T>
  bool Plus(const T* x, const T* delta, T* out) const {
    const T twice[3] = {T(2.0) * delta[0], T(2.0) * delta[1], T(2.0) * delta[2]};
    T q[4];
    vesta::AngleAxisToQuaternion(twice, q);
    vesta::QuaternionProduct(q, x, out);
    return true;
  }
};

TEST(CeresCasesManifold, DifferentiatedFunctors) {
  srand(7);
  ExpectSameManifold(AutoDiffManifold<Scaled, 3, 3>(), ceres::EuclideanManifold<3>());
  const AutoDiffManifold<Scaled, 3, 3> scaled(Scaled{1.2342});
  const Eigen::Vector3d x = Eigen::Vector3d::Random(), delta = Eigen::Vector3d::Random();
  EXPECT_LE((PlusOf(scaled, x, delta) - x - 1.2342 * delta).norm(), 1e-15);
  ExpectPlusJacobian(scaled, x);
  for (const double scale : {1.0, 1e-6, std::numbers::pi - 1e-6}) {
    ExpectSameManifold(AutoDiffManifold<Turn, 4, 3>(), ceres::QuaternionManifold(), true, scale);
  }
}

}  // namespace
}  // namespace vesta::test
