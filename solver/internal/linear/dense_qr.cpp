// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/linear/dense_qr.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vesta {

// J S = Q R, where S scales columns to unit length; c = Q^T r. Later steps need only R and c.
struct DenseQr::Factors {
  Eigen::MatrixXd r;
  Eigen::VectorXd c;
  Eigen::VectorXd scale;
};

DenseQr::DenseQr(int rows, int cols, std::vector<double> jacobian, std::vector<double> residuals)
    : factors_(std::make_unique<Factors>()) {
  const int padded = std::max(rows, cols);
  if (padded > rows) {
    for (int k = cols; k > 0; --k) {
      jacobian.insert(jacobian.begin() + static_cast<std::ptrdiff_t>(k) * rows, static_cast<std::size_t>(padded - rows),
                      0);
    }
    residuals.resize(static_cast<std::size_t>(padded), 0);
  }
  Eigen::Map<Eigen::MatrixXd> j(jacobian.data(), padded, cols);
  Eigen::Map<Eigen::VectorXd> f(residuals.data(), padded);
  factors_->scale.resize(cols);
  for (int k = 0; k < cols; ++k) {
    const double norm = j.col(k).stableNorm();
    factors_->scale[k] = norm > 0 ? 1 / norm : 1;
    j.col(k) *= factors_->scale[k];
  }
  const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(j);  // in place
  factors_->r = qr.matrixQR().topRows(cols).triangularView<Eigen::Upper>();
  f.applyOnTheLeft(qr.householderQ().adjoint());
  factors_->c = f.head(cols);
}

DenseQr::~DenseQr() = default;
DenseQr::DenseQr(DenseQr&&) noexcept = default;
DenseQr& DenseQr::operator=(DenseQr&&) noexcept = default;

namespace {

// As DenseQr::Solve. With kMax >= cols the work memory is on the stack, which saves a third of the time for few
// columns.
template <int kMax>
void SolveDamped(const Eigen::MatrixXd& r, const Eigen::VectorXd& c, const Eigen::VectorXd& scale,
                 std::vector<double>& damping_and_solution) {
  constexpr int kStackedMax = kMax == Eigen::Dynamic ? Eigen::Dynamic : 2 * kMax;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kStackedMax, kMax>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMax, 1>;
  using StackedVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kStackedMax, 1>;
  const Eigen::Index n = r.cols();
  Eigen::Map<Eigen::VectorXd> x(damping_and_solution.data(), n);
  Matrix stacked(2 * n, n);
  stacked.topRows(n) = r;
  stacked.bottomRows(n).setZero();
  stacked.bottomRows(n).diagonal() = x.cwiseSqrt().cwiseProduct(scale);
  StackedVector rhs = StackedVector::Zero(2 * n);
  rhs.head(n) = -c;
  // Scale the columns again, because the damping may dominate J in some of them.
  Vector norms(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    norms[k] = stacked.col(k).norm();
    if (norms[k] > 0) stacked.col(k) /= norms[k];
  }
  const Eigen::ColPivHouseholderQR<Matrix> qr(std::move(stacked));
  x = qr.solve(rhs);
  for (Eigen::Index k = 0; k < n; ++k) x[k] *= norms[k] > 0 ? scale[k] / norms[k] : 0.0;
}

}  // namespace

std::vector<double> DenseQr::Solve(std::vector<double> damping) const {
  constexpr int kFewColumns = 8;
  const auto solve = factors_->r.cols() <= kFewColumns ? SolveDamped<kFewColumns> : SolveDamped<Eigen::Dynamic>;
  solve(factors_->r, factors_->c, factors_->scale, damping);
  return damping;
}

DenseQr::Inverse DenseQr::NormalInverse(double relative_threshold, int null_space_rank, bool scale_columns) const {
  const Eigen::Index n = factors_->r.cols();
  const Eigen::VectorXd scale = scale_columns ? factors_->scale : Eigen::VectorXd::Ones(n);
  // J S = Q r with S = diag(scale).
  Eigen::MatrixXd r = factors_->r;
  if (!scale_columns) r *= factors_->scale.cwiseInverse().asDiagonal();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(r, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::VectorXd& sigma = svd.singularValues();  // in descending order
  Inverse inverse;
  while (inverse.rank < n && sigma[inverse.rank] > relative_threshold * sigma[0]) ++inverse.rank;
  const Eigen::Index used = null_space_rank < 0 ? inverse.rank : std::max<Eigen::Index>(0, n - null_space_rank);
  if (used > inverse.rank) return inverse;
  // S V Sigma^-1 without the ignored directions. Its product with its transpose is (J^T J)^-1, or a generalised
  // inverse.
  Eigen::MatrixXd half = svd.matrixV().leftCols(used) * sigma.head(used).cwiseInverse().asDiagonal();
  half.applyOnTheLeft(scale.asDiagonal());
  if (scale_columns && used > 0 && used < n) {
    // A generalised inverse becomes the pseudo-inverse if it is projected onto the complement of the ignored
    // directions.
    const Eigen::MatrixXd ignored = scale.asDiagonal() * svd.matrixV().rightCols(n - used);
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(ignored);
    half.applyOnTheLeft(qr.householderQ().adjoint());
    half.topRows(n - used).setZero();
    half.applyOnTheLeft(qr.householderQ());
  }
  const Eigen::MatrixXd product = half * half.transpose();
  inverse.values.assign(product.data(), product.data() + n * n);
  return inverse;
}

}  // namespace vesta
