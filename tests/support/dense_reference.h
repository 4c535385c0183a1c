// SPDX-License-Identifier: Apache-2.0
// Dense linear algebra as a reference for tests. It is compiled once, because every file that instantiates Eigen's
// decompositions or matrix products compiles for many seconds, and much longer with sanitizers.
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

// Least squares by QR, for A of full column rank.
Eigen::VectorXd LeastSquares(const Eigen::MatrixXd& a, const ConstVectorRef& b);
// The least-squares solution of minimum norm, for A of any rank.
Eigen::VectorXd LeastNorm(const Eigen::MatrixXd& a, const ConstVectorRef& b);
// A^-1 b for a symmetric A, by LDL^T.
Eigen::VectorXd SolveSymmetric(const Eigen::MatrixXd& a, const ConstVectorRef& b);
// S = A - B C^-1 B^T of [A B; B^T C], where A has `kept` rows.
Eigen::MatrixXd SchurComplement(const Eigen::MatrixXd& symmetric, Eigen::Index kept);
// L of A = L L^T.
Eigen::MatrixXd CholeskyFactor(const Eigen::MatrixXd& a);
Eigen::MatrixXd Inverse(const Eigen::MatrixXd& a);
// An orthonormal basis of the columns of A: Q of its thin QR decomposition.
Eigen::MatrixXd Orthonormal(const Eigen::MatrixXd& a);
// The eigenvalues of a symmetric A in ascending order.
Eigen::VectorXd SymmetricEigenvalues(const Eigen::MatrixXd& a);

}  // namespace vesta::test
