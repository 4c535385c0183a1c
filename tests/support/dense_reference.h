// SPDX-License-Identifier: Apache-2.0
// Dense linear algebra that tests compare with, compiled once: every file that instantiates one of Eigen's
// decompositions or matrix products for itself compiles for many seconds, under the sanitizers for tens of them.
#pragma once

#include <Eigen/Core>

namespace vesta::test {

using ConstVectorRef = Eigen::Ref<const Eigen::VectorXd>;

// A B.
Eigen::MatrixXd Multiply(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
// A x.
Eigen::VectorXd Apply(const Eigen::MatrixXd& a, const ConstVectorRef& x);
// A^T y.
Eigen::VectorXd ApplyTransposed(const Eigen::MatrixXd& a, const ConstVectorRef& y);
// A^T A.
Eigen::MatrixXd Gram(const Eigen::MatrixXd& a);

// Least squares for A of full column rank, by QR.
Eigen::VectorXd LeastSquares(const Eigen::MatrixXd& a, const ConstVectorRef& b);
// The least-squares solution of least norm, for A of any rank.
Eigen::VectorXd LeastNorm(const Eigen::MatrixXd& a, const ConstVectorRef& b);
// A^-1 b for a symmetric A, by LDL^T.
Eigen::VectorXd SolveSymmetric(const Eigen::MatrixXd& a, const ConstVectorRef& b);
// S = A - B C^-1 B^T of [A B; B^T C], where A has `kept` rows.
Eigen::MatrixXd SchurComplement(const Eigen::MatrixXd& symmetric, Eigen::Index kept);
// L of A = L L^T.
Eigen::MatrixXd CholeskyFactor(const Eigen::MatrixXd& a);
Eigen::MatrixXd Inverse(const Eigen::MatrixXd& a);
// The columns of A made orthonormal: Q of its QR, as many columns as A has.
Eigen::MatrixXd Orthonormal(const Eigen::MatrixXd& a);
// Of a symmetric A, the least first.
Eigen::VectorXd SymmetricEigenvalues(const Eigen::MatrixXd& a);

}  // namespace vesta::test
