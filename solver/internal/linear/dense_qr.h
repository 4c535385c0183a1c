// SPDX-License-Identifier: Apache-2.0
// Dense least squares by Householder QR, for small problems: the accuracy of J's own condition number.
#pragma once

#include <memory>
#include <vector>

namespace vesta {

// argmin |J x + r|^2 + lambda x^T D x for one J and r and any number of lambda: J is factorised once.
class DenseQr {
 public:
  // jacobian: rows x cols, column after column; residuals: rows. Both finite.
  DenseQr(int rows, int cols, const std::vector<double>& jacobian, const std::vector<double>& residuals);
  ~DenseQr();
  DenseQr(DenseQr&&) noexcept;
  DenseQr& operator=(DenseQr&&) noexcept;

  // x, cols entries. damping: lambda D, >= 0. Columns are equilibrated; directions of no weight in working precision
  // get 0.
  std::vector<double> Solve(const std::vector<double>& damping) const;

  // (J^T J)^-1, cols x cols. In directions whose singular value, with columns scaled to length 1, is at or below
  // relative_threshold times the largest: `truncate` leaves them out (the pseudo-inverse), otherwise the result is
  // empty. Rank: the number of directions above.
  struct Inverse {
    int rank = 0;
    std::vector<double> values;
  };
  Inverse NormalInverse(double relative_threshold, bool truncate) const;

 private:
  struct Factors;
  std::unique_ptr<Factors> factors_;
};

}  // namespace vesta
