// Covariances of chosen blocks of a problem whose dense Jacobian would be too large (solver/covariance.h).
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "solver/block_problem.h"

namespace vesta {

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
