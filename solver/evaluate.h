// SPDX-License-Identifier: Apache-2.0
// Residuals, gradient and sparse Jacobian of a BlockProblem, as ceres::Problem::Evaluate computes them.
#pragma once

#include <optional>
#include <vector>

#include "solver/block_problem.h"

namespace vesta {

// A sparse matrix in compressed row storage. The entries of row i have the positions row_starts[i] to
// row_starts[i + 1] - 1 in `columns`, in ascending order, and in `values`. Entries that are stored may be 0.
struct CrsMatrix {
  Index rows = 0, cols = 0;
  std::vector<Index> row_starts = {0};
  std::vector<Index> columns = {};
  std::vector<double> values = {};
};

struct EvaluateOptions {
  // The residual blocks to evaluate, in this order; by default all, in ascending order.
  std::optional<std::vector<Index>> residual_blocks = {};
  // The parameter blocks of the gradient and the columns of the Jacobian, in this order and without repeats; by default
  // all, in ascending order. Each has as many columns as its tangent space. Those of a constant block are 0, and are
  // not stored.
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

// Evaluates the residual blocks in parallel. If a cost function returns false, the cost, its residuals and its entries
// of the Jacobian are NaN. Throws Error if x has the wrong size, a block does not exist, or a parameter block is
// repeated.
BlockEvaluation Evaluate(BlockProblem& problem, BlockProblem::B::ConstVectorView x,
                         const EvaluateOptions& options = {});

}  // namespace vesta
