// SPDX-License-Identifier: Apache-2.0
// Dense linear algebra with Eigen, as a reference. Compiled once: each file with Eigen's decompositions or matrix
// products takes many seconds, and much longer with sanitizers.
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

// The x that minimises |A x - b|, by QR. A must have full column rank.
Eigen::VectorXd LeastSquares(const Eigen::MatrixXd& a, const ConstVectorRef& b);
// The x of smallest norm that minimises |A x - b|, for any rank.
Eigen::VectorXd LeastNorm(const Eigen::MatrixXd& a, const ConstVectorRef& b);
// A^-1 b for a symmetric A, by LDL^T.
Eigen::VectorXd SolveSymmetric(const Eigen::MatrixXd& a, const ConstVectorRef& b);
// S = A - B C^-1 B^T of the symmetric matrix [A B; B^T C], where A has `kept` rows.
Eigen::MatrixXd SchurComplement(const Eigen::MatrixXd& symmetric, Eigen::Index kept);
// The lower triangular L with A = L L^T.
Eigen::MatrixXd CholeskyFactor(const Eigen::MatrixXd& a);
Eigen::MatrixXd Inverse(const Eigen::MatrixXd& a);
// An orthonormal basis of the columns of A: Q of its thin QR decomposition.
Eigen::MatrixXd Orthonormal(const Eigen::MatrixXd& a);
// Eigenvalues of a symmetric A, ascending.
Eigen::VectorXd SymmetricEigenvalues(const Eigen::MatrixXd& a);

}  // namespace vesta::test
