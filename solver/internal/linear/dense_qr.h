// SPDX-License-Identifier: Apache-2.0
// Dense least squares by Householder QR, for small problems. The accuracy depends on J's condition number, not on its
// square.
#pragma once

#include <memory>
#include <vector>

namespace vesta {

// argmin |J x + r|^2 + lambda x^T D x for one J and r and any number of lambda. J is factorised once.
class DenseQr {
 public:
  // jacobian: rows x cols, column-major; residuals: rows entries. Both must be finite.
  DenseQr(int rows, int cols, std::vector<double> jacobian, std::vector<double> residuals);
  ~DenseQr();
  DenseQr(DenseQr&&) noexcept;
  DenseQr& operator=(DenseQr&&) noexcept;

  // Returns x, cols entries. damping: lambda D, >= 0. Columns are scaled to equal length. Directions that are singular
  // in working precision get 0.
  std::vector<double> Solve(std::vector<double> damping) const;

  // (J^T J)^-1, cols x cols. J's columns are scaled to length 1; a direction is singular if its singular value is at
  // most relative_threshold times the largest. truncate = true drops such directions (the pseudo-inverse); otherwise
  // the result is empty if there is one. rank: the number of other directions.
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
