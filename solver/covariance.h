// SPDX-License-Identifier: Apache-2.0
// Covariance of an estimate: by a dense Jacobian, or of chosen blocks by a sparse factor.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "solver/block_problem.h"
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

// Covariances of chosen blocks of a problem whose dense Jacobian would be too large.
struct BlockCovariance {
  // Of two parameter blocks, in their tangent spaces: rows of the first one's, columns of the second one's, row after
  // row; none for a constant block. Multiply by the variance of the residuals where that is not 1.
  struct Block {
    int rows = 0, cols = 0;
    std::vector<double> values = {};
    double operator()(int row, int col) const { return values[static_cast<std::size_t>(Index{row} * cols + col)]; }
  };
  // Directions that H shows no information about, in working precision; then there are no blocks.
  Index num_singular = 0;
  std::vector<Block> blocks = {};  // in the order of the pairs asked for
};

// At x, where the fit ended: blocks of (J^T J)^-1, losses applied, by the sparse Cholesky factor of J^T J, one solve
// for each column of a pair's second block. Digits are lost to the square of J's condition number. Throws Error where
// the factor would be over the problem's max_factor_gib.
BlockCovariance EstimateBlockCovariance(BlockProblem& problem, CpuBackend<double>::ConstVectorView x,
                                        std::span<const std::pair<int, int>> pairs);

}  // namespace vesta
