// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/linear/dense_qr.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "solver/internal/linear/householder.h"

namespace vesta {

namespace {

// Up to this number of columns, the loops of householder.h are faster than Eigen's.
constexpr int kFewColumns = 16;

// A norm whose squares do not overflow or underflow.
double StableNorm(const double* x, int n) {
  const double square = householder::Dot(x, x, n);
  if (square > 1e-280 && square < 1e280) return std::sqrt(square);
  return Eigen::Map<const Eigen::VectorXd>(x, n).stableNorm();
}

}  // namespace

// J S = Q R, where S scales columns to unit length; c = Q^T r. Later steps need only R and c.
struct DenseQr::Factors {
  int rows, cols;
  std::vector<double> a;  // rows x cols, column-major; R is its upper triangle
  std::vector<double> c;  // in the first cols entries
  std::vector<double> scale;

  auto R() const {
    return Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>(a.data(), cols, cols, Eigen::OuterStride<>(rows))
        .triangularView<Eigen::Upper>();
  }
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
  *factors_ = {padded, cols, std::move(jacobian), std::move(residuals),
               std::vector<double>(static_cast<std::size_t>(cols))};
  double* const a = factors_->a.data();
  for (int k = 0; k < cols; ++k) {
    double* const column = a + static_cast<std::ptrdiff_t>(k) * padded;
    const double norm = StableNorm(column, padded), scale = norm > 0 ? 1 / norm : 1;
    factors_->scale[static_cast<std::size_t>(k)] = scale;
    for (int i = 0; i < padded; ++i) column[i] *= scale;
  }
  if (cols <= kFewColumns) {
    for (int k = 0; k < cols; ++k) householder::Reflect(a, padded, cols, k, factors_->c.data());
  } else {
    Eigen::Map<Eigen::MatrixXd> j(a, padded, cols);
    const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(j);  // in place
    Eigen::Map<Eigen::VectorXd>(factors_->c.data(), padded).applyOnTheLeft(qr.householderQ().adjoint());
  }
}

DenseQr::~DenseQr() = default;
DenseQr::DenseQr(DenseQr&&) noexcept = default;
DenseQr& DenseQr::operator=(DenseQr&&) noexcept = default;

namespace {

// The least-squares problem of DenseQr::Solve: [R; sqrt(lambda D) S] x = [-c; 0], with columns scaled to unit length
// again, because the damping may dominate J in some of them. stacked: 2n x n, column-major, zero before the call; rhs:
// 2n entries, likewise. damping_and_scale: on return, the factors from the solution to x.
template <class R>
void Stack(const R& r, const double* c, const std::vector<double>& scale, std::span<double> damping_and_scale,
           double* stacked, double* rhs) {
  const auto n = static_cast<int>(damping_and_scale.size());
  for (int k = 0; k < n; ++k) {
    double* const column = stacked + static_cast<std::ptrdiff_t>(k) * 2 * n;
    for (int i = 0; i <= k; ++i) column[i] = r.coeff(i, k);
    double& entry = damping_and_scale[static_cast<std::size_t>(k)];
    const double s = scale[static_cast<std::size_t>(k)];
    column[n + k] = std::sqrt(entry) * s;
    const double norm = std::sqrt(householder::Dot(column, column, k + 1) + column[n + k] * column[n + k]);
    entry = norm > 0 ? s / norm : 0;
    if (norm > 0) {
      for (int i = 0; i <= k; ++i) column[i] /= norm;
      column[n + k] /= norm;
    }
    rhs[k] = -c[k];
  }
}

// The x that minimises |A x - b|, by Householder QR with column pivoting. a: rows x n, column-major, n <= kFewColumns;
// both are overwritten. x is 0 in directions that are singular in working precision.
void SolveFewColumns(int rows, int n, double* a, double* b, double* x) {
  int order[kFewColumns];
  std::iota(order, order + n, 0);
  const auto column = [&](int k) { return a + static_cast<std::ptrdiff_t>(k) * rows; };
  double largest = 0;
  int rank = 0;
  for (; rank < n; ++rank) {
    int pivot = rank;
    double square = -1;
    for (int k = rank; k < n; ++k) {
      const double candidate = householder::Dot(column(k) + rank, column(k) + rank, rows - rank);
      if (candidate <= square) continue;  // NaN is chosen, so that x becomes NaN
      pivot = k, square = candidate;
    }
    if (rank == 0) largest = square;
    constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
    if (square <= kEpsilon * kEpsilon * largest) break;
    if (pivot != rank) {
      std::swap_ranges(column(pivot), column(pivot) + rows, column(rank));
      std::swap(order[pivot], order[rank]);
    }
    householder::Reflect(a, rows, n, rank, b);
  }
  std::fill_n(x, n, 0.0);
  for (int k = rank - 1; k >= 0; --k) {
    double value = b[k];
    for (int j = k + 1; j < rank; ++j) value -= column(j)[k] * x[order[j]];
    x[order[k]] = value / column(k)[k];
  }
}

}  // namespace

void DenseQr::Solve(std::span<double> damping_and_solution) const {
  const int n = factors_->cols;
  double few[2 * kFewColumns * (kFewColumns + 1) + kFewColumns];
  std::vector<double> many;
  double* stacked = few;
  const int size = 2 * n * n + 2 * n;
  if (n <= kFewColumns) {
    std::fill_n(few, size, 0.0);
  } else {
    many.resize(static_cast<std::size_t>(size) + static_cast<std::size_t>(n));
    stacked = many.data();
  }
  double *const rhs = stacked + 2 * n * n, *const x = stacked + size;
  Stack(factors_->R(), factors_->c.data(), factors_->scale, damping_and_solution, stacked, rhs);
  if (n <= kFewColumns) {
    SolveFewColumns(2 * n, n, stacked, rhs, x);
  } else {
    Eigen::Map<Eigen::MatrixXd> a(stacked, 2 * n, n);
    Eigen::Map<Eigen::VectorXd>(x, n) =
        Eigen::ColPivHouseholderQR<Eigen::Ref<Eigen::MatrixXd>>(a).solve(Eigen::Map<const Eigen::VectorXd>(rhs, 2 * n));
  }
  for (int k = 0; k < n; ++k) damping_and_solution[static_cast<std::size_t>(k)] *= x[k];
}

DenseQr::Inverse DenseQr::NormalInverse(double relative_threshold, int null_space_rank, bool scale_columns) const {
  const Eigen::Index n = factors_->cols;
  const Eigen::VectorXd scale = scale_columns
                                    ? Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(factors_->scale.data(), n))
                                    : Eigen::VectorXd::Ones(n);
  // J S = Q r with S = diag(scale).
  Eigen::MatrixXd r = factors_->R();
  if (!scale_columns) r *= Eigen::Map<const Eigen::VectorXd>(factors_->scale.data(), n).cwiseInverse().asDiagonal();
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
