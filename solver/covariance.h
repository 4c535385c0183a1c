// SPDX-License-Identifier: Apache-2.0
// Covariance of an estimate. It uses a dense Jacobian for all parameters, or a sparse factor for chosen blocks.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "solver/block_problem.h"
#include "solver/problem.h"

namespace vesta {

struct CovarianceOptions {
  // A direction of the tangent space is called unobservable (such as a gauge freedom) if its singular value is at most
  // this times the largest one. The columns of J are scaled to length 1 first. Within [0, 1).
  double relative_threshold = 1e-12;
  // true: ignore unobservable directions (the pseudo-inverse, as Ceres's null_space_rank = -1). false: return no values
  // if there is one.
  bool truncate = false;
};

struct Covariance {
  int size = 0;  // dimension of the tangent space
  int rank = 0;  // number of observable directions
  // (J^T J)^-1, row-major; empty if rank < size and truncate is false. Multiply it by the variance of the residuals if
  // that is not 1.
  std::vector<double> values = {};
  double operator()(int row, int col) const {
    return values[static_cast<std::size_t>(row) * static_cast<std::size_t>(size) + static_cast<std::size_t>(col)];
  }
};

// Computes (J^T J)^-1 in the tangent space at the solution x, with losses applied. It uses QR and SVD of J, so the
// accuracy depends on J's condition number, not on its square. Throws Error if the Jacobian would exceed 1e8 entries or
// the problem has weights W. If J is not finite, rank is 0.
Covariance EstimateCovariance(Problem<CpuBackend<double>>& problem, CpuBackend<double>::ConstVectorView x,
                              const CovarianceOptions& options = {});

// Covariances of chosen blocks of a problem whose dense Jacobian would be too large.
struct BlockCovariance {
  // Covariance of two parameter blocks in their tangent spaces, row-major. The rows belong to the pair's first block,
  // the columns to its second. Empty if a block is constant. Multiply it by the variance of the residuals if that is
  // not 1.
  struct Block {
    int rows = 0, cols = 0;
    std::vector<double> values = {};
    double operator()(int row, int col) const { return values[static_cast<std::size_t>(Index{row} * cols + col)]; }
  };
  // Number of directions in which H is singular in working precision. If it is not 0, `blocks` is empty.
  Index num_singular = 0;
  std::vector<Block> blocks = {};  // in the order of the pairs
};

// Computes blocks of (J^T J)^-1 at the solution x, with losses applied. It uses the sparse Cholesky factor of J^T J and
// one solve per column of a pair's second block. The accuracy depends on the square of J's condition number. Throws
// Error if the factor would exceed the problem's max_factor_gib.
BlockCovariance EstimateBlockCovariance(BlockProblem& problem, CpuBackend<double>::ConstVectorView x,
                                        std::span<const std::pair<int, int>> pairs);

}  // namespace vesta
