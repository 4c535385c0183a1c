// SPDX-License-Identifier: Apache-2.0
// Residual blocks of a BlockProblem that are evaluated together.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "kernels/core/buffer.h"
#include "problems/program/differentiate.h"
#include "problems/program/program.h"
#include "problems/program/run_program.h"
#include "solver/block_problem.h"

namespace vesta::program {

using ConstVectorView = BlockProblem::B::ConstVectorView;

// Residual blocks of the same sizes, called rows. Evaluate computes all of them; then each row copies its part.
class Batch {
 public:
  virtual ~Batch() = default;
  // Computes the residuals of all rows at x and, if `jacobians`, their Jacobians.
  virtual void Evaluate(ConstVectorView x, bool jacobians) = 0;
  // The result for one row, with the arguments of CostFunction::Evaluate. Called by several threads at once.
  virtual bool CopyRow(Index row, double* residuals, double** jacobians) const = 0;
};

// A BlockProblem whose residual blocks belong to batches.
class BatchProblem {
 public:
  explicit BatchProblem(BlockProblem::Options options = {});
  BatchProblem(const BatchProblem&) = delete;
  BatchProblem& operator=(const BatchProblem&) = delete;

  BlockProblem& blocks() { return blocks_; }
  // Adds a batch with num_rows rows of num_residuals residuals. blocks: the parameter blocks of all rows, one row after
  // another; block_sizes: their sizes in each row. Throws Error if blocks do not fit.
  void Add(std::shared_ptr<Batch> batch, Index num_rows, int num_residuals, const std::vector<int>& block_sizes,
           std::span<const int> blocks, const std::shared_ptr<const Loss>& loss = nullptr);

 private:
  BlockProblem blocks_;
  std::vector<std::shared_ptr<Batch>> batches_;
  std::vector<std::shared_ptr<const std::vector<int>>> sizes_;  // block_sizes of each batch
};

// Residuals by a program. Its inputs are the entries of the row's parameter blocks, one block after another, then the
// row's data.
class ProgramBatch final : public Batch {
 public:
  // residuals: has sum(block_sizes) + num_data inputs. blocks: as in BatchProblem::Add, of `problem`, to which the
  // batch will be added. data: num_data arrays of num_rows numbers, one array after another. Throws Error for wrong
  // sizes.
  ProgramBatch(const BlockProblem& problem, const Program& residuals, const std::vector<int>& block_sizes,
               std::span<const int> blocks, std::span<const double> data);

  Index num_rows() const { return num_rows_; }
  void Evaluate(ConstVectorView x, bool jacobians) override;
  bool CopyRow(Index row, double* residuals, double** jacobians) const override;

 private:
  struct Entry {
    int block, position;  // in the row-major Jacobian of the block
  };
  void SetEntries(const std::vector<JacobianEntry>& entries);
  void SetPositions(const BlockProblem& problem, const Program& residuals, std::span<const int> blocks);
  // Evaluates the chunks begin, ..., end - 1.
  void RunChunks(const ProgramPlan& plan, const double* x, double* outputs, Index begin, Index end) const;

  int num_residuals_, num_variables_, num_data_;
  Index num_rows_, num_chunks_;
  std::vector<int> used_;  // variables that the program reads
  std::vector<int> block_sizes_;
  ProgramPlan residuals_, derivatives_;
  std::vector<Entry> entries_;
  bool dense_;  // no entry of the Jacobian is always 0
  // Arrays of kChunk numbers: for each chunk of rows, one array per used variable (position in x), datum or output.
  Buffer<Index, Host> positions_;
  Buffer<double, Host> data_, outputs_;
  int num_outputs_ = 0;  // per row, of the last evaluation
};

}  // namespace vesta::program
