// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/linear/lsmr.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/solver/dense_operator.h"

namespace vesta {
namespace {

Eigen::VectorXd Solve(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, LsmrSummary* summary,
                      LsmrOptions options = {.max_iterations = 1000, .relative_tolerance = 1e-15}) {
  Cpu backend;
  DenseMap map(a);
  Cpu::Vector rhs(b.size()), x(a.cols());
  AsEigen(rhs.view()) = b;
  *summary = SolveLsmr<Cpu>(options, backend, map, rhs, x);
  return AsEigen(x.view());
}

TEST(Lsmr, SolvesLeastSquares) {
  srand(3);
  const Eigen::MatrixXd a = Eigen::MatrixXd::Random(30, 12);
  const Eigen::VectorXd b = Eigen::VectorXd::Random(30);
  LsmrSummary summary;
  const Eigen::VectorXd x = Solve(a, b, &summary);
  const Eigen::VectorXd expected = test::LeastSquares(a, b);
  EXPECT_LE((x - expected).norm(), 1e-12 * expected.norm());
  // The norms from the recursions equal the true norms.
  EXPECT_NEAR(summary.residual_norm, (b - test::Apply(a, x)).norm(), 1e-12);
  LsmrOptions early{.max_iterations = 4, .relative_tolerance = 1e-15};
  const Eigen::VectorXd y = Solve(a, b, &summary, early);
  EXPECT_EQ(summary.iterations, 4);
  EXPECT_FALSE(summary.converged);
  EXPECT_NEAR(summary.residual_norm, (b - test::Apply(a, y)).norm(), 1e-12);
  EXPECT_NEAR(summary.normal_residual_norm, test::ApplyTransposed(a, b - test::Apply(a, y)).norm(), 1e-12);
}

TEST(Lsmr, FindsTheSolutionOfLeastNorm) {
  srand(4);
  const Eigen::MatrixXd a = test::Multiply(Eigen::MatrixXd::Random(10, 3), Eigen::MatrixXd::Random(3, 6));
  const Eigen::VectorXd b = Eigen::VectorXd::Random(10);
  LsmrSummary summary;
  const Eigen::VectorXd x = Solve(a, b, &summary, {.max_iterations = 100, .relative_tolerance = 1e-12});
  const Eigen::VectorXd expected = test::LeastNorm(a, b);
  EXPECT_LE((x - expected).norm(), 1e-10 * expected.norm());
}

// At condition number 1e7, normal equations keep two digits of double; LSMR is as accurate as QR.
TEST(Lsmr, SeesTheConditionNumberOnce) {
  srand(5);
  const Eigen::MatrixXd u = test::Orthonormal(Eigen::MatrixXd::Random(40, 8));
  const Eigen::MatrixXd v = test::Orthonormal(Eigen::MatrixXd::Random(8, 8));
  Eigen::VectorXd sigma(8);
  for (int k = 0; k < 8; ++k) sigma[k] = std::pow(10.0, -k);
  const Eigen::MatrixXd a = test::Multiply(u * sigma.asDiagonal(), v.transpose());
  const Eigen::VectorXd truth = Eigen::VectorXd::Random(8), b = test::Apply(a, truth);
  LsmrSummary summary;
  const Eigen::VectorXd x = Solve(a, b, &summary);
  EXPECT_LE((x - truth).norm(), 1e-7 * truth.norm());
  const Eigen::VectorXd normal = test::SolveSymmetric(test::Gram(a), test::ApplyTransposed(a, b));
  EXPECT_GE((normal - truth).norm(), 1e-5 * truth.norm());
}

TEST(Lsmr, EndsOnNumbersThatAreNone) {
  Eigen::MatrixXd a = Eigen::MatrixXd::Identity(4, 2);
  LsmrSummary summary;
  EXPECT_EQ(Solve(a, Eigen::VectorXd::Zero(4), &summary).norm(), 0);
  EXPECT_TRUE(summary.converged);
  // b orthogonal to the range of A.
  EXPECT_EQ(Solve(a, Eigen::Vector4d(0, 0, 1, 2), &summary).norm(), 0);
  EXPECT_TRUE(summary.converged);
  a(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(Solve(a, Eigen::VectorXd::Ones(4), &summary).allFinite());
  EXPECT_FALSE(summary.finite);
}

}  // namespace
}  // namespace vesta
