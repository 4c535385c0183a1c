// SPDX-License-Identifier: Apache-2.0
// Dense least squares by Householder QR, for small problems. The accuracy depends on J's condition number, not on the
// square of it, unlike with the normal equations.
#pragma once

#include <memory>
#include <span>
#include <vector>

namespace vesta {

// Computes the x that minimises |J x + r|^2 + lambda x^T D x. J is factorised once for any number of dampings lambda D.
class DenseQr {
 public:
  // jacobian: rows x cols, column-major; residuals: rows entries. Both must be finite.
  DenseQr(int rows, int cols, std::vector<double> jacobian, std::vector<double> residuals);
  ~DenseQr();
  DenseQr(DenseQr&&) noexcept;
  DenseQr& operator=(DenseQr&&) noexcept;

  // damping_and_solution has cols entries. On entry: the diagonal of lambda D, all >= 0. On return: x. In directions
  // that are singular in working precision, x is 0.
  void Solve(std::span<double> damping_and_solution) const;

  // (J^T J)^-1, cols x cols; see CovarianceOptions for the arguments. If directions are ignored, `values` is the
  // pseudo-inverse. `values` is empty if another direction is singular. rank: number of nonsingular directions.
  struct Inverse {
    int rank = 0;
    std::vector<double> values;
  };
  Inverse NormalInverse(double relative_threshold, int null_space_rank, bool scale_columns) const;

 private:
  struct Factors;
  std::unique_ptr<Factors> factors_;
};

}  // namespace vesta
