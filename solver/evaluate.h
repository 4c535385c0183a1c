// SPDX-License-Identifier: Apache-2.0
// Residuals, gradient and sparse Jacobian of a BlockProblem, as ceres::Problem::Evaluate computes them.
#pragma once

#include <optional>
#include <vector>

#include "solver/block_problem.h"

namespace vesta {

// A sparse matrix in compressed row storage. The entries of row i have the positions row_starts[i] to
// row_starts[i + 1] - 1 in `columns`, in ascending order, and in `values`. A stored entry may be 0.
struct CrsMatrix {
  Index rows = 0, cols = 0;
  std::vector<Index> row_starts = {0};
  std::vector<Index> columns = {};
  std::vector<double> values = {};
};

struct EvaluateOptions {
  // The residual blocks to evaluate, in this order; by default all, in ascending order.
  std::optional<std::vector<Index>> residual_blocks = {};
  // The parameter blocks of the gradient and of the Jacobian's columns, in this order and without repeats; by default
  // all, in ascending order. A block has one column per dimension of its tangent space. The columns of a constant block
  // are 0, and are not stored.
  std::optional<std::vector<int>> parameter_blocks = {};
  // Apply the losses: the cost contains rho, and residuals and Jacobian are corrected as for a solve (LossCorrection).
  bool apply_loss = true;
  // Compute the gradient and the Jacobian.
  bool derivatives = true;
};

struct BlockEvaluation {
  double cost = 0;
  std::vector<double> residuals = {};
  std::vector<double> gradient = {};  // J^T residuals
  CrsMatrix jacobian = {};
};

// Evaluates the residual blocks in parallel. If a cost function returns false, the cost is NaN, and so are the
// residuals and Jacobian entries of this residual block. Throws Error if x has the wrong size, a block does not exist,
// or a parameter block is repeated.
BlockEvaluation Evaluate(BlockProblem& problem, BlockProblem::B::ConstVectorView x,
                         const EvaluateOptions& options = {});

}  // namespace vesta
