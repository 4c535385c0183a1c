// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/linear/dense_qr.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/random.h"

namespace vesta {
namespace {

Eigen::MatrixXd RandomMatrix(int rows, int cols) {
  test::Random random(static_cast<unsigned>(100 * rows + cols));
  Eigen::MatrixXd m(rows, cols);
  for (double& x : m.reshaped()) x = random.Normal();
  return m;
}

Eigen::VectorXd Solve(const Eigen::MatrixXd& j, const Eigen::VectorXd& r, const Eigen::VectorXd& damping) {
  const DenseQr qr(static_cast<int>(j.rows()), static_cast<int>(j.cols()), {j.reshaped().begin(), j.reshaped().end()},
                   {r.begin(), r.end()});
  std::vector<double> x(damping.begin(), damping.end());
  qr.Solve(x);
  return Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
}

// The solution of the normal equations, in long double.
Eigen::VectorXd Expected(const Eigen::MatrixXd& j, const Eigen::VectorXd& r, const Eigen::VectorXd& damping) {
  using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  const Matrix wide = j.cast<long double>();
  Matrix h = wide.transpose() * wide;
  h.diagonal() += damping.cast<long double>();
  return h.ldlt().solve(-wide.transpose() * r.cast<long double>()).cast<double>();
}

// 16 columns are the most for which the loops are this library's, not Eigen's.
TEST(DenseQr, SolvesDampedLeastSquares) {
  for (const int cols : {1, 2, 3, 6, 16, 17, 30}) {
    for (const int rows : {1, cols, 2 * cols + 3, 100}) {
      const Eigen::MatrixXd j = RandomMatrix(rows, cols);
      const Eigen::VectorXd r = RandomMatrix(rows, 1), damping = RandomMatrix(cols, 1).cwiseAbs();
      const Eigen::VectorXd expected = Expected(j, r, damping);
      EXPECT_LT((Solve(j, r, damping) - expected).norm(), 1e-10 * expected.norm()) << rows << " x " << cols;
    }
  }
}

TEST(DenseQr, AccuracyDependsOnTheConditionNumberOfJ) {
  for (const int cols : {4, 20}) {
    Eigen::MatrixXd j = RandomMatrix(40, cols);
    j.col(1) = j.col(0) + 1e-7 * j.col(1);
    j.col(2) *= 1e200;
    j.col(3) *= 1e-200;
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(cols, 1, 2);
    const Eigen::VectorXd scale = j.cwiseAbs().colwise().maxCoeff().transpose();
    const Eigen::VectorXd expected = x.cwiseQuotient(scale);
    const Eigen::VectorXd found = Solve(j, -j * expected, Eigen::VectorXd::Zero(cols));
    EXPECT_LT((found.cwiseProduct(scale) - x).norm(), 1e-7) << cols;
  }
}

TEST(DenseQr, ZeroColumnsDoNotMove) {
  for (const int cols : {3, 20}) {
    Eigen::MatrixXd j = RandomMatrix(30, cols);
    j.col(1).setZero();
    const Eigen::VectorXd r = RandomMatrix(30, 1), x = Solve(j, r, Eigen::VectorXd::Zero(cols));
    EXPECT_EQ(x[1], 0);
    EXPECT_LT((j.transpose() * (j * x + r)).norm(), 1e-12 * j.norm() * r.norm());
  }
}

TEST(DenseQr, DampingMayDominate) {
  for (const int cols : {2, 17}) {
    const Eigen::MatrixXd j = RandomMatrix(30, cols);
    const Eigen::VectorXd r = RandomMatrix(30, 1);
    const Eigen::VectorXd x = Solve(j, r, Eigen::VectorXd::Constant(cols, 1e10));
    EXPECT_LT((1e10 * x + j.transpose() * r).norm(), 1e-7 * r.norm());
    const Eigen::VectorXd infinite = Eigen::VectorXd::Constant(cols, std::numeric_limits<double>::infinity());
    EXPECT_FALSE(Solve(j, r, infinite).allFinite());
  }
}

}  // namespace
}  // namespace vesta
