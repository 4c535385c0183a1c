// Covariance of an estimate, for problems small enough for a dense Jacobian.
#pragma once

#include <string>
#include <vector>

#include "solver/problem.h"

namespace vesta {

struct CovarianceOptions {
  // Directions whose singular value, columns of J scaled to length 1, is at or below this times the largest have no
  // information; within [0, 1).
  double relative_threshold = 1e-12;
  // true: such directions are left out (the pseudo-inverse; Ceres's null_space_rank = -1). false: the result is empty.
  bool truncate = false;
};

struct Covariance {
  int size = 0;  // of the tangent space
  int rank = 0;  // directions with information
  // (J^T J)^-1, row after row; empty where rank < size and nothing was truncated. Multiply by the variance of the
  // residuals where that is not 1.
  std::vector<double> values = {};
  double operator()(int row, int col) const {
    return values[static_cast<std::size_t>(row) * static_cast<std::size_t>(size) + static_cast<std::size_t>(col)];
  }
};

// At x, where the fit ended: (J^T J)^-1 in the tangent space, losses applied. By QR and SVD of J, so that J's own
// condition number decides how many digits there are. Throws Error where the Jacobian would exceed 1e8 entries or the
// problem has weights W; numbers that are not finite give rank 0.
Covariance EstimateCovariance(Problem<CpuBackend<double>>& problem, CpuBackend<double>::ConstVectorView x,
                              const CovarianceOptions& options = {});

}  // namespace vesta
