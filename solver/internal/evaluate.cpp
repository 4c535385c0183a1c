// SPDX-License-Identifier: Apache-2.0
#include "solver/evaluate.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta {

class BlockEvaluator {
 public:
  BlockEvaluator(BlockProblem& problem, BlockProblem::B::ConstVectorView x, const EvaluateOptions& options)
      : problem_(problem), x_(x), options_(options) {
    problem.CheckSize(x);
    blocks_ = options.residual_blocks ? *options.residual_blocks : problem.residual_blocks();
    if (options.derivatives) NumberColumns();
    PlaceRows();
  }

  BlockEvaluation Run() {
    if (problem_.options_.evaluation_callback) problem_.options_.evaluation_callback(x_, options_.derivatives);
    std::vector<double> costs(blocks_.size());
    ParallelForChunks(static_cast<Index>(blocks_.size()), 64, [&](Index begin, Index end) {
      BlockProblem::Scratch scratch;
      for (Index k = begin; k < end; ++k) costs[At(k)] = EvaluateBlock(At(k), scratch);
    });
    for (const double cost : costs) result_.cost += cost;
    const CrsMatrix& jacobian = result_.jacobian;
    for (Index row = 0; row < jacobian.rows; ++row) {
      for (Index k = jacobian.row_starts[At(row)]; k < jacobian.row_starts[At(row) + 1]; ++k) {
        result_.gradient[At(jacobian.columns[At(k)])] += jacobian.values[At(k)] * result_.residuals[At(row)];
      }
    }
    return std::move(result_);
  }

 private:
  static std::size_t At(Index i) { return static_cast<std::size_t>(i); }

  void NumberColumns() {
    first_column_.assign(problem_.parameters_.size(), -1);
    Index& columns = result_.jacobian.cols;
    for (const int block : options_.parameter_blocks ? *options_.parameter_blocks : problem_.parameter_blocks()) {
      const Manifold* const manifold = problem_.manifold(block).get();  // throws for unknown blocks
      VESTA_CHECK(first_column_[At(block)] < 0, "parameter block {} is repeated", block);
      first_column_[At(block)] = columns;
      columns += manifold ? manifold->tangent_size() : problem_.parameter_block_size(block);
    }
    result_.gradient.resize(At(columns));
  }

  // The columns of residual block k, as cells of a dense matrix. Its columns ascend as in the whole Jacobian.
  std::vector<BlockCell> CellsOf(std::size_t k) const {
    std::vector<BlockCell> cells;
    if (!options_.derivatives) return cells;
    const std::span<const int> parameters = problem_.parameter_blocks_of(blocks_[k]);
    for (std::size_t argument = 0; argument < parameters.size(); ++argument) {
      const auto p = At(parameters[argument]);
      const int size = problem_.parameters_[p].tangent_size;
      if (first_column_[p] < 0 || size == 0) continue;
      cells.push_back({.argument = static_cast<int>(argument), .size = size, .offset = first_column_[p]});
    }
    std::sort(cells.begin(), cells.end(), [](const BlockCell& a, const BlockCell& b) { return a.offset < b.offset; });
    int width = 0;
    for (BlockCell& cell : cells) {
      cell.local = width;
      width += cell.size;
    }
    return cells;
  }
  static int WidthOf(std::span<const BlockCell> cells) {
    return cells.empty() ? 0 : cells.back().local + cells.back().size;
  }

  void PlaceRows() {
    CrsMatrix& jacobian = result_.jacobian;
    Index rows = 0;
    for (std::size_t k = 0; k < blocks_.size(); ++k) {
      first_row_.push_back(rows);
      const int count = problem_.cost_function(blocks_[k])->num_residuals();  // throws for unknown blocks
      rows += count;
      if (!options_.derivatives) continue;
      const std::vector<BlockCell> cells = CellsOf(k);
      for (int i = 0; i < count; ++i) {
        for (const BlockCell& cell : cells) {
          for (int c = 0; c < cell.size; ++c) jacobian.columns.push_back(cell.offset + c);
        }
        jacobian.row_starts.push_back(static_cast<Index>(jacobian.columns.size()));
      }
      jacobian.rows = rows;
    }
    jacobian.values.resize(jacobian.columns.size());
    result_.residuals.resize(At(rows));
  }

  // Writes the rows of residual block k, and returns its cost.
  double EvaluateBlock(std::size_t k, BlockProblem::Scratch& scratch) {
    const auto term = At(blocks_[k]);
    const int count = problem_.residuals_[term].num_residuals;
    double* const residuals = result_.residuals.data() + first_row_[k];
    const std::vector<BlockCell> cells = CellsOf(k);
    const int width = WidthOf(cells);
    double* jacobian = nullptr;
    if (options_.derivatives) {
      jacobian = result_.jacobian.values.data() + result_.jacobian.row_starts[At(first_row_[k])];
      std::fill_n(jacobian, count * width, std::numeric_limits<double>::quiet_NaN());
      problem_.LinearizeTerm(x_, term, cells, width, residuals, jacobian, scratch);
    } else {
      problem_.TermCost(x_, term, scratch);
      std::copy(scratch.residuals.begin(), scratch.residuals.end(), residuals);
    }
    double s = 0;
    for (int i = 0; i < count; ++i) s += residuals[i] * residuals[i];
    const Loss* const loss = options_.apply_loss ? problem_.terms_[term].loss.get() : nullptr;
    if (loss == nullptr) return 0.5 * s;
    const Loss::Value value = loss->Evaluate(s);
    LossCorrection(value, s).Apply(count, width, residuals, jacobian, width, 1);
    return 0.5 * value.rho;
  }

  BlockProblem& problem_;
  const BlockProblem::B::ConstVectorView x_;
  const EvaluateOptions& options_;
  std::vector<Index> blocks_;        // the residual blocks
  std::vector<Index> first_row_;     // of each residual block
  std::vector<Index> first_column_;  // per parameter block of the problem; -1 if it was not chosen
  BlockEvaluation result_;
};

BlockEvaluation Evaluate(BlockProblem& problem, BlockProblem::B::ConstVectorView x, const EvaluateOptions& options) {
  return BlockEvaluator(problem, x, options).Run();
}

}  // namespace vesta
