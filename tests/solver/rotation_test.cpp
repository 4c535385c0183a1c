// SPDX-License-Identifier: Apache-2.0
#include "solver/rotation.h"

#include <ceres/jet.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <vector>

#include "kernels/core/random.h"
#include "kernels/math/derivatives.h"
#include "kernels/math/dual.h"

namespace vesta {
namespace {

using Jet = ceres::Jet<double, 4>;

// Values and Jacobian (row-major) of f: n numbers to m numbers, by dual numbers or by Jets.
struct Result {
  Eigen::VectorXd value;
  Eigen::MatrixXd jacobian;
};
template <class F>
Result ByDuals(const Eigen::VectorXd& x, int outputs, const F& f) {
  Result result{Eigen::VectorXd(outputs), Eigen::MatrixXd(outputs, x.size())};
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    std::vector<Dual<double>> in, out(static_cast<std::size_t>(outputs));
    for (Eigen::Index i = 0; i < x.size(); ++i) in.push_back({x[i], i == k ? 1.0 : 0.0});
    f(in.data(), out.data());
    for (int i = 0; i < outputs; ++i) {
      result.value[i] = out[static_cast<std::size_t>(i)].a;
      result.jacobian(i, k) = out[static_cast<std::size_t>(i)].v;
    }
  }
  return result;
}
// The same with four derivatives at once.
template <class F>
Result ByWideDuals(const Eigen::VectorXd& x, int outputs, const F& f) {
  std::vector<Dual<double, 4>> in(x.begin(), x.end()), out(static_cast<std::size_t>(outputs));
  for (std::size_t i = 0; i < in.size(); ++i) in[i].v[static_cast<int>(i)] = 1;
  f(in.data(), out.data());
  Result result{Eigen::VectorXd(outputs), Eigen::MatrixXd(outputs, x.size())};
  for (int i = 0; i < outputs; ++i) {
    result.value[i] = out[static_cast<std::size_t>(i)].a;
    for (int k = 0; k < x.size(); ++k) result.jacobian(i, k) = out[static_cast<std::size_t>(i)].v[k];
  }
  return result;
}
template <class F>
Result ByJets(const Eigen::VectorXd& x, int outputs, const F& f) {
  std::vector<Jet> in, out(static_cast<std::size_t>(outputs));
  for (Eigen::Index i = 0; i < x.size(); ++i) in.emplace_back(x[i], static_cast<int>(i));
  f(in.data(), out.data());
  Result result{Eigen::VectorXd(outputs), Eigen::MatrixXd(outputs, x.size())};
  for (int i = 0; i < outputs; ++i) {
    result.value[i] = out[static_cast<std::size_t>(i)].a;
    result.jacobian.row(i) = out[static_cast<std::size_t>(i)].v.head(x.size());
  }
  return result;
}
void ExpectSame(const Result& ours, const Result& theirs, double tolerance, const char* what) {
  EXPECT_LE((ours.value - theirs.value).norm(), tolerance * (1 + theirs.value.norm())) << what;
  EXPECT_LE((ours.jacobian - theirs.jacobian).norm(), tolerance * (1 + theirs.jacobian.norm())) << what;
}

Eigen::VectorXd Random(CounterRandom& random, int size) {
  return Eigen::VectorXd::NullaryExpr(size, [&] { return random.Normal(); });
}
Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d matrix;
  matrix << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return matrix;
}
// The rotation of a vector w and the left Jacobian J of the rotation group: R(w + d) = R(J d) R(w) to first order.
Eigen::Matrix3d Rodrigues(const Eigen::Vector3d& w, int first) {
  double c[3];
  AngleCoefficients(w.squaredNorm(), c);
  const Eigen::Matrix3d cross = CrossMatrix(w);
  return Eigen::Matrix3d::Identity() + c[first] * cross + c[first + 1] * cross * cross;
}

constexpr double kPi = std::numbers::pi;
const double kAngles[] = {0, 1e-300, 1e-160, 1e-20, 1e-9, 1e-8, 2e-8, 1e-7, 1e-5, 1e-3, 0.1, 1, 3, kPi - 1e-3, 4, 7};

TEST(Rotation, PointsTurnByRotationVectorsWithExactDerivatives) {
  CounterRandom random(1, 1);
  for (const double angle : kAngles) {
    const Eigen::Vector3d w = angle * Random(random, 3).normalized(), p = Random(random, 3);
    const Result turned = ByDuals(w, 3, [&](const auto* vector, auto* out) {
      using T = std::decay_t<decltype(*out)>;
      const T point[3] = {T(p[0]), T(p[1]), T(p[2])};
      AngleAxisRotatePoint(vector, point, out);
    });
    const Eigen::Vector3d expected = Rodrigues(w, 0) * p;
    EXPECT_LE((turned.value - expected).norm(), 4e-15 * p.norm()) << angle;
    EXPECT_LE((turned.jacobian + CrossMatrix(expected) * Rodrigues(w, 1)).norm(), 1e-14 * p.norm()) << angle;
    // In place, and by the matrix.
    double in_place[3] = {p[0], p[1], p[2]}, rows[9], columns[9];
    AngleAxisRotatePoint(w.data(), in_place, in_place);
    EXPECT_EQ((Eigen::Map<Eigen::Vector3d>(in_place) - turned.value).norm(), 0);
    AngleAxisToRotationMatrix(w.data(), RowMajorAdapter3x3(rows));
    AngleAxisToRotationMatrix(w.data(), columns);
    const Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> matrix(rows);
    EXPECT_LE((matrix - Rodrigues(w, 0)).norm(), 4e-15) << angle;
    EXPECT_EQ((Eigen::Map<Eigen::Matrix3d>(columns) - matrix).norm(), 0);
  }
}

TEST(Rotation, ConversionsAndTheirDerivativesAreInverse) {
  CounterRandom random(1, 2);
  for (const double angle : kAngles) {
    if (angle >= kPi) continue;
    const Eigen::Vector3d w = angle * Random(random, 3).normalized();
    const Result by_quaternion = ByDuals(w, 3, [](const auto* vector, auto* out) {
      std::decay_t<decltype(*out)> q[4];
      AngleAxisToQuaternion(vector, q);
      QuaternionToAngleAxis(q, out);
    });
    const Result by_matrix = ByDuals(w, 3, [](const auto* vector, auto* out) {
      std::decay_t<decltype(*out)> R[9];
      AngleAxisToRotationMatrix(vector, R);
      RotationMatrixToAngleAxis(R, out);
    });
    for (const Result& result : {by_quaternion, by_matrix}) {
      // A matrix near the identity defines the angle only up to its rounding.
      EXPECT_LE((result.value - w).norm(), 1e-14 * (1 + angle)) << angle;
      EXPECT_LE((result.jacobian - Eigen::Matrix3d::Identity()).norm(), 1e-12) << angle;
    }
    EXPECT_LE((by_quaternion.value - w).norm(), 1e-14 * angle) << angle;
  }
}

TEST(Rotation, NegativeQuaternionsAreTheSameRotation) {
  // Near -1, small vector parts turn the other way round.
  for (const double tiny : {0.0, 1e-300, 1e-9, 0.3}) {
    const Eigen::Vector4d q(-std::sqrt(1 - tiny * tiny), tiny, 0, 0);
    const auto convert = [](const auto* in, auto* out) { QuaternionToAngleAxis(in, out); };
    const Result negative = ByDuals(q, 3, convert), positive = ByDuals(-q, 3, convert);
    EXPECT_EQ((negative.value - positive.value).norm(), 0);
    EXPECT_EQ((negative.jacobian + positive.jacobian).norm(), 0);
    EXPECT_NEAR(negative.value[0], -2 * std::asin(tiny), 1e-15);
  }
}

TEST(Rotation, FunctionsAreCeress) {
  CounterRandom random(1, 3);
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3d w = 2 * Random(random, 3), p = Random(random, 3);
    const Eigen::Vector4d q = Random(random, 4), unit = q.normalized();
    double matrix[9];
    ceres::AngleAxisToRotationMatrix(w.data(), matrix);
    const Eigen::VectorXd R = Eigen::Map<Eigen::VectorXd>(matrix, 9);
    const auto expect = [&](const char* what, const Eigen::VectorXd& x, int outputs, const auto& ours,
                            const auto& theirs) {
      ExpectSame(ByDuals(x, outputs, ours), ByJets(x, outputs, theirs), 1e-12, what);
      ExpectSame(ByWideDuals(x, outputs, ours), ByJets(x, outputs, theirs), 1e-12, what);
      ExpectSame(ByJets(x, outputs, ours), ByJets(x, outputs, theirs), 1e-12, what);
    };
    const auto point = [&](auto* out) {
      for (int i = 0; i < 3; ++i) out[i] = std::decay_t<decltype(*out)>(p[i]);
    };
#define EXPECT_CERESS(x, outputs, CALL)                      \
  expect(                                                    \
      #CALL, x, outputs,                                     \
      [&](const auto* in, auto* out) {                       \
        [[maybe_unused]] std::decay_t<decltype(*out)> at[3]; \
        point(at);                                           \
        vesta::CALL;                                         \
      },                                                     \
      [&](const auto* in, auto* out) {                       \
        [[maybe_unused]] std::decay_t<decltype(*out)> at[3]; \
        point(at);                                           \
        ceres::CALL;                                         \
      })
    EXPECT_CERESS(w, 4, AngleAxisToQuaternion(in, out));
    EXPECT_CERESS(unit, 3, QuaternionToAngleAxis(in, out));
    EXPECT_CERESS(w, 9, AngleAxisToRotationMatrix(in, out));
    EXPECT_CERESS(q, 9, QuaternionToRotation(in, out));
    EXPECT_CERESS(q, 9, QuaternionToScaledRotation(in, out));
    EXPECT_CERESS(unit, 3, UnitQuaternionRotatePoint(in, at, out));
    EXPECT_CERESS(q, 3, QuaternionRotatePoint(in, at, out));
    EXPECT_CERESS(w, 3, AngleAxisRotatePoint(in, at, out));
    EXPECT_CERESS(w, 9, EulerAnglesToRotationMatrix(in, 3, out));
    EXPECT_CERESS(w, 3, CrossProduct(in, at, out));
#undef EXPECT_CERESS
    double ours[4], theirs[4];
    RotationMatrixToQuaternion(R.data(), ours);
    ceres::RotationMatrixToQuaternion(R.data(), theirs);
    const double sign = theirs[0] < 0 ? -1 : 1;
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(ours[i], sign * theirs[i], 1e-14);
    RotationMatrixToAngleAxis(R.data(), ours);
    ceres::RotationMatrixToAngleAxis(R.data(), theirs);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(ours[i], theirs[i], 1e-12);
    EXPECT_EQ(DotProduct(w.data(), p.data()), ceres::DotProduct(w.data(), p.data()));
  }
}

}  // namespace
}  // namespace vesta
