// SPDX-License-Identifier: Apache-2.0
// Covariance of the solution of a least-squares problem. EstimateCovariance computes it for all parameters, from the
// dense Jacobian J. EstimateBlockCovariance computes it for chosen blocks, from a sparse factor of J^T J.
// CovarianceBlocks takes blocks from the dense result.
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
  // most relative_threshold times the largest one. Within [0, 1). Ceres's min_reciprocal_condition_number is the square
  // of this value.
  double relative_threshold = 1e-12;
  // Number of directions to ignore, beginning with the smallest singular value; -1: all unobservable ones. If another
  // direction is unobservable, the result has no values.
  int null_space_rank = 0;
  // Scale the columns of J to length 1 before the singular values are computed. The rank then does not depend on the
  // units of the parameters. false: as Ceres.
  bool scale_columns = true;
};

struct Covariance {
  int size = 0;  // dimension of the tangent space
  int rank = 0;  // number of observable directions
  // (J^T J)^-1, row-major, size x size; empty if an unobservable direction is not ignored. If directions are ignored,
  // this is the Moore-Penrose pseudo-inverse of J^T J without them, so the variance along them is 0. If the variance of
  // the residuals is not 1, multiply the values by that variance.
  std::vector<double> values = {};
  double operator()(int row, int col) const {
    return values[static_cast<std::size_t>(row) * static_cast<std::size_t>(size) + static_cast<std::size_t>(col)];
  }
};

// Computes (J^T J)^-1 in the tangent space at the solution x, with losses applied. It uses QR and SVD of J, so the
// accuracy depends on J's condition number, not on the square of it. Throws Error if the Jacobian would exceed 1e8
// entries, or if the problem has weights W (WithLossWeights). If J is not finite, rank is 0, and there are no values.
Covariance EstimateCovariance(Problem<CpuBackend<double>>& problem, CpuBackend<double>::ConstVectorView x,
                              const CovarianceOptions& options = {});

// Coordinates of the covariance of a parameter block. kTangent: a step. kAmbient: the block's own numbers. If C is the
// covariance in kTangent, it is P C P^T in kAmbient, where P is Manifold::PlusJacobian.
enum class CovarianceSpace { kTangent, kAmbient };

// Covariances of chosen blocks.
struct BlockCovariance {
  // Covariance of a pair of parameter blocks, row-major. The rows belong to the pair's first block, the columns to its
  // second. Empty if one of the blocks is constant or in no residual block. If the variance of the residuals is not 1,
  // multiply the values by that variance.
  struct Block {
    int rows = 0, cols = 0;
    std::vector<double> values = {};
    double operator()(int row, int col) const { return values[static_cast<std::size_t>(Index{row} * cols + col)]; }
  };
  // Number of directions in which J^T J is singular in working precision. If it is not 0, EstimateBlockCovariance
  // returns no blocks.
  Index num_singular = 0;
  std::vector<Block> blocks = {};  // in the order of the pairs
};

// Computes blocks of (J^T J)^-1 at the solution x, with losses applied. pairs: indices of two parameter blocks each. It
// uses the sparse Cholesky factor of J^T J, and solves one linear system per column of a pair's second block. The
// accuracy depends on the square of J's condition number. Throws Error if the factor would exceed the problem's
// max_factor_gib.
BlockCovariance EstimateBlockCovariance(BlockProblem& problem, CpuBackend<double>::ConstVectorView x,
                                        std::span<const std::pair<int, int>> pairs,
                                        CovarianceSpace space = CovarianceSpace::kTangent);

// Returns the same blocks from `covariance`, the result of EstimateCovariance at x. It may be a pseudo-inverse.
// num_singular is size - rank. If `covariance` has no values, `blocks` is empty.
BlockCovariance CovarianceBlocks(BlockProblem& problem, CpuBackend<double>::ConstVectorView x,
                                 const Covariance& covariance, std::span<const std::pair<int, int>> pairs,
                                 CovarianceSpace space = CovarianceSpace::kTangent);

}  // namespace vesta
