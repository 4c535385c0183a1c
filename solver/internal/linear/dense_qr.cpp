// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/linear/dense_qr.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>

namespace vesta {

// J S = Q R, where S scales columns to unit length; c = Q^T r. Later steps need only R and c.
struct DenseQr::Factors {
  Eigen::MatrixXd r;
  Eigen::VectorXd c;
  Eigen::VectorXd scale;
};

DenseQr::DenseQr(int rows, int cols, const std::vector<double>& jacobian, const std::vector<double>& residuals)
    : factors_(std::make_unique<Factors>()) {
  Eigen::MatrixXd j = Eigen::Map<const Eigen::MatrixXd>(jacobian.data(), rows, cols);
  Eigen::VectorXd f = Eigen::Map<const Eigen::VectorXd>(residuals.data(), rows);
  factors_->scale.resize(cols);
  for (int k = 0; k < cols; ++k) {
    const double norm = j.col(k).stableNorm();
    factors_->scale[k] = norm > 0 ? 1 / norm : 1;
    j.col(k) *= factors_->scale[k];
  }
  if (rows < cols) {
    j.conservativeResize(cols, Eigen::NoChange);
    j.bottomRows(cols - rows).setZero();
    f.conservativeResize(cols);
    f.tail(cols - rows).setZero();
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(j);
  factors_->r = qr.matrixQR().topRows(cols).triangularView<Eigen::Upper>();
  f.applyOnTheLeft(qr.householderQ().adjoint());
  factors_->c = f.head(cols);
}

DenseQr::~DenseQr() = default;
DenseQr::DenseQr(DenseQr&&) noexcept = default;
DenseQr& DenseQr::operator=(DenseQr&&) noexcept = default;

std::vector<double> DenseQr::Solve(const std::vector<double>& damping) const {
  const Eigen::Index n = factors_->r.cols();
  const Eigen::VectorXd& scale = factors_->scale;
  Eigen::MatrixXd stacked(2 * n, n);
  stacked.topRows(n) = factors_->r;
  stacked.bottomRows(n) =
      (Eigen::Map<const Eigen::VectorXd>(damping.data(), n).cwiseSqrt().cwiseProduct(scale)).asDiagonal();
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(2 * n);
  rhs.head(n) = -factors_->c;
  // Scale the columns again, because the damping may dominate J in some of them.
  const Eigen::VectorXd norms = stacked.colwise().norm();
  for (Eigen::Index k = 0; k < n; ++k) {
    if (norms[k] > 0) stacked.col(k) /= norms[k];
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(stacked);
  Eigen::VectorXd x = qr.solve(rhs);
  for (Eigen::Index k = 0; k < n; ++k) x[k] *= norms[k] > 0 ? scale[k] / norms[k] : 0.0;
  return {x.data(), x.data() + n};
}

DenseQr::Inverse DenseQr::NormalInverse(double relative_threshold, bool truncate) const {
  const Eigen::Index n = factors_->r.cols();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(factors_->r, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::VectorXd& sigma = svd.singularValues();
  Inverse inverse;
  Eigen::MatrixXd half = svd.matrixV();  // V Sigma^-1, with singular directions set to zero
  for (Eigen::Index k = 0; k < n; ++k) {
    const bool counts = sigma[k] > 0 && sigma[k] > relative_threshold * sigma[0];
    inverse.rank += counts ? 1 : 0;
    half.col(k) *= counts ? 1 / sigma[k] : 0.0;
  }
  if (inverse.rank < n && !truncate) return inverse;
  half.applyOnTheLeft(factors_->scale.asDiagonal());
  const Eigen::MatrixXd product = half * half.transpose();
  inverse.values.assign(product.data(), product.data() + n * n);
  return inverse;
}

}  // namespace vesta
