// SPDX-License-Identifier: Apache-2.0
#include "tests/support/dense_reference.h"

#include <Eigen/Dense>

namespace vesta::test {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd Multiply(const MatrixXd& a, const MatrixXd& b) { return a * b; }
VectorXd Apply(const MatrixXd& a, const ConstVectorRef& x) { return a * x; }
VectorXd ApplyTransposed(const MatrixXd& a, const ConstVectorRef& y) { return a.transpose() * y; }
MatrixXd Gram(const MatrixXd& a) { return a.transpose() * a; }

VectorXd LeastSquares(const MatrixXd& a, const ConstVectorRef& b) { return a.householderQr().solve(b); }
VectorXd LeastNorm(const MatrixXd& a, const ConstVectorRef& b) { return a.completeOrthogonalDecomposition().solve(b); }
VectorXd SolveSymmetric(const MatrixXd& a, const ConstVectorRef& b) { return a.ldlt().solve(b); }

MatrixXd SchurComplement(const MatrixXd& symmetric, Eigen::Index kept) {
  const Eigen::Index rest = symmetric.rows() - kept;
  const MatrixXd b = symmetric.topRightCorner(kept, rest);
  return symmetric.topLeftCorner(kept, kept) -
         b * MatrixXd(symmetric.bottomRightCorner(rest, rest)).ldlt().solve(b.transpose());
}

MatrixXd CholeskyFactor(const MatrixXd& a) { return a.llt().matrixL(); }
MatrixXd Inverse(const MatrixXd& a) { return a.inverse(); }
MatrixXd Orthonormal(const MatrixXd& a) {
  return a.householderQr().householderQ() * MatrixXd::Identity(a.rows(), a.cols());
}
VectorXd SymmetricEigenvalues(const MatrixXd& a) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

}  // namespace vesta::test
