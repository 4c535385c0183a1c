// SPDX-License-Identifier: Apache-2.0
// Covariance of the solution of a least-squares problem. EstimateCovariance computes it for all parameters, from the
// dense Jacobian J. EstimateBlockCovariance computes it for chosen blocks, from a sparse factor of J^T J.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "solver/block_problem.h"
#include "solver/problem.h"

namespace vesta {

struct CovarianceOptions {
  // A direction of the tangent space counts as unobservable (for example a gauge freedom) if its singular value is at
  // most relative_threshold times the largest one. The columns of J are scaled to length 1 before the singular values
  // are computed. Within [0, 1).
  double relative_threshold = 1e-12;
  // true: ignore unobservable directions (the pseudo-inverse, as Ceres's null_space_rank = -1). false: return no values
  // if any direction is unobservable.
  bool truncate = false;
};

struct Covariance {
  int size = 0;  // dimension of the tangent space
  int rank = 0;  // number of observable directions
  // (J^T J)^-1, row-major, size x size; empty if rank < size and truncate is false. If the variance of the residuals is
  // not 1, multiply the values by it.
  std::vector<double> values = {};
  double operator()(int row, int col) const {
    return values[static_cast<std::size_t>(row) * static_cast<std::size_t>(size) + static_cast<std::size_t>(col)];
  }
};

// Computes (J^T J)^-1 in the tangent space at the solution x, with losses applied. It uses QR and SVD of J, so the
// accuracy depends on J's condition number, not on the square of it. Throws Error if the Jacobian would exceed 1e8
// entries, or if the problem has weights W (WithLossWeights). If J is not finite, rank is 0.
Covariance EstimateCovariance(Problem<CpuBackend<double>>& problem, CpuBackend<double>::ConstVectorView x,
                              const CovarianceOptions& options = {});

// Covariances of chosen blocks of a problem whose dense Jacobian would be too large.
struct BlockCovariance {
  // Covariance of a pair of parameter blocks in their tangent spaces, row-major. The rows belong to the pair's first
  // block, the columns to its second. Empty if a block is constant or in no residual block. If the variance of the
  // residuals is not 1, multiply the values by it.
  struct Block {
    int rows = 0, cols = 0;
    std::vector<double> values = {};
    double operator()(int row, int col) const { return values[static_cast<std::size_t>(Index{row} * cols + col)]; }
  };
  // Number of directions in which J^T J is singular in working precision. If it is not 0, `blocks` is empty.
  Index num_singular = 0;
  std::vector<Block> blocks = {};  // in the order of the pairs
};

// Computes blocks of (J^T J)^-1 at the solution x, with losses applied. pairs: indices of two parameter blocks each. It
// uses the sparse Cholesky factor of J^T J, and solves one linear system per column of a pair's second block. The
// accuracy depends on the square of J's condition number. Throws Error if the factor would exceed the problem's
// max_factor_gib.
BlockCovariance EstimateBlockCovariance(BlockProblem& problem, CpuBackend<double>::ConstVectorView x,
                                        std::span<const std::pair<int, int>> pairs);

}  // namespace vesta
