// SPDX-License-Identifier: Apache-2.0
#include "problems/program/batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

#include "kernels/core/error.h"
#include "kernels/core/parallel.h"

namespace vesta::program {

namespace {

// A row of a batch, as the problem sees it.
class RowCost final : public CostFunction {
 public:
  RowCost(const Batch& batch, Index row, int num_residuals, std::span<const int> block_sizes)
      : CostFunction(num_residuals, block_sizes), batch_(batch), row_(row) {}
  bool Evaluate(const double* const*, double* residuals, double** jacobians) const override {
    return batch_.CopyRow(row_, residuals, jacobians);
  }

 private:
  const Batch& batch_;
  Index row_;
};

Index NumRows(std::span<const int> blocks, std::size_t blocks_per_row) {
  if (blocks_per_row == 0 || blocks.size() % blocks_per_row != 0) {
    throw Error(kBadArgument,
                fmt::format("{} parameter blocks cannot be divided into rows of {}", blocks.size(), blocks_per_row));
  }
  return static_cast<Index>(blocks.size() / blocks_per_row);
}

}  // namespace

BatchProblem::BatchProblem(BlockProblem::Options options) : blocks_(std::move(options)) {
  blocks_.set_evaluation_callback([this](ConstVectorView x, bool jacobians) {
    for (const std::shared_ptr<Batch>& batch : batches_) batch->Evaluate(x, jacobians);
  });
}

void BatchProblem::Add(std::shared_ptr<Batch> batch, Index num_rows, int num_residuals,
                       const std::vector<int>& block_sizes, std::span<const int> blocks,
                       const std::shared_ptr<const Loss>& loss) {
  if (NumRows(blocks, block_sizes.size()) != num_rows) {
    throw Error(kBadArgument,
                fmt::format("{} rows of {} parameter blocks need {} block numbers, not {}", num_rows,
                            block_sizes.size(), num_rows * static_cast<Index>(block_sizes.size()), blocks.size()));
  }
  const auto sizes = std::make_shared<const std::vector<int>>(block_sizes);
  std::vector<RowCost> costs;
  costs.reserve(static_cast<std::size_t>(num_rows));
  for (Index row = 0; row < num_rows; ++row) costs.emplace_back(*batch, row, num_residuals, std::span(*sizes));
  blocks_.AddResidualBlocks(std::move(costs), blocks, loss);
  sizes_.push_back(sizes);
  batches_.push_back(std::move(batch));
}

ProgramBatch::ProgramBatch(const BlockProblem& problem, const Program& residuals, const std::vector<int>& block_sizes,
                           std::span<const int> blocks, std::span<const double> data)
    : num_residuals_(static_cast<int>(residuals.outputs.size())),
      num_variables_(std::accumulate(block_sizes.begin(), block_sizes.end(), 0)),
      num_data_(residuals.num_inputs - num_variables_),
      num_rows_(NumRows(blocks, block_sizes.size())),
      num_chunks_((num_rows_ + kChunk - 1) / kChunk),
      block_sizes_(block_sizes),
      residuals_(residuals),
      derivatives_(Program{}) {
  if (num_data_ < 0 || static_cast<Index>(data.size()) != num_data_ * num_rows_) {
    throw Error(kBadArgument, fmt::format("{} inputs of the program, {} variables and {} rows do not fit {} data",
                                          residuals.num_inputs, num_variables_, num_rows_, data.size()));
  }
  const Derivatives derivatives = Differentiate(residuals, num_variables_);
  derivatives_ = ProgramPlan(derivatives.program);
  SetEntries(derivatives.entries);
  SetPositions(problem, residuals, blocks);
  // The last chunk is filled up with its last row.
  data_.Resize(num_chunks_ * num_data_ * kChunk);
  for (Index chunk = 0; chunk < num_chunks_; ++chunk) {
    for (int d = 0; d < num_data_; ++d) {
      for (int i = 0; i < kChunk; ++i) {
        data_[(chunk * num_data_ + d) * kChunk + i] =
            data[static_cast<std::size_t>(d * num_rows_ + std::min(chunk * kChunk + i, num_rows_ - 1))];
      }
    }
  }
}

void ProgramBatch::SetEntries(const std::vector<JacobianEntry>& entries) {
  std::vector<int> block_of, column_of;
  for (std::size_t b = 0; b < block_sizes_.size(); ++b) {
    for (int c = 0; c < block_sizes_[b]; ++c) {
      block_of.push_back(static_cast<int>(b));
      column_of.push_back(c);
    }
  }
  for (const JacobianEntry& entry : entries) {
    const auto v = static_cast<std::size_t>(entry.variable);
    const int size = block_sizes_[static_cast<std::size_t>(block_of[v])];
    entries_.push_back({block_of[v], entry.output * size + column_of[v]});
  }
  dense_ = static_cast<int>(entries_.size()) == num_residuals_ * num_variables_;
}

void ProgramBatch::SetPositions(const BlockProblem& problem, const Program& residuals, std::span<const int> blocks) {
  std::vector<bool> used(static_cast<std::size_t>(num_variables_));
  for (const Instruction& instruction : residuals.instructions) {
    if (instruction.operation == Operation::kInput && instruction.a < num_variables_) {
      used[static_cast<std::size_t>(instruction.a)] = true;
    }
  }
  std::vector<std::pair<std::size_t, int>> used_entries;  // block of the row, entry of the block
  int variable = 0;
  for (std::size_t b = 0; b < block_sizes_.size(); ++b) {
    for (int c = 0; c < block_sizes_[b]; ++c, ++variable) {
      if (!used[static_cast<std::size_t>(variable)]) continue;
      used_.push_back(variable);
      used_entries.emplace_back(b, c);
    }
  }
  positions_.Resize(num_chunks_ * static_cast<Index>(used_.size()) * kChunk);
  Index next = 0;
  for (Index chunk = 0; chunk < num_chunks_; ++chunk) {
    for (const auto& [b, c] : used_entries) {
      for (int i = 0; i < kChunk; ++i) {
        const auto row = static_cast<std::size_t>(std::min(chunk * kChunk + i, num_rows_ - 1));
        const int block = blocks[row * block_sizes_.size() + b];
        if (problem.parameter_block_size(block) != block_sizes_[b]) {
          throw Error(kBadArgument, fmt::format("parameter block {} has {} numbers, not {}", block,
                                                problem.parameter_block_size(block), block_sizes_[b]));
        }
        positions_[next++] = problem.offset(block) + c;
      }
    }
  }
}

void ProgramBatch::Evaluate(ConstVectorView x, bool jacobians) {
  const ProgramPlan& plan = jacobians ? derivatives_ : residuals_;
  num_outputs_ = plan.num_outputs();
  outputs_.ResizeForOverwrite(num_chunks_ * num_outputs_ * kChunk);
  constexpr Index kChunksPerTask = 8;
  ParallelForChunks(num_chunks_, kChunksPerTask,
                    [&](Index begin, Index end) { RunChunks(plan, x.data(), outputs_.data(), begin, end); });
}

void ProgramBatch::RunChunks(const ProgramPlan& plan, const double* x, double* outputs, Index begin, Index end) const {
  const int num_shared = plan.num_inputs() + plan.num_outputs();  // arrays outside of `own`
  const int num_constants = static_cast<int>(plan.constants().size());
  const int num_used = static_cast<int>(used_.size());
  Buffer<double, Host> own;  // constants, results, then the used variables
  own.ResizeForOverwrite((plan.num_arrays() - num_shared + num_used) * kChunk);
  std::vector<double*> arrays(static_cast<std::size_t>(plan.num_arrays()), own.data());
  for (int i = num_shared; i < plan.num_arrays(); ++i) {
    arrays[static_cast<std::size_t>(i)] = own.data() + (i - num_shared) * kChunk;
  }
  for (int i = 0; i < num_constants; ++i) {
    std::fill_n(own.data() + i * kChunk, kChunk, plan.constants()[static_cast<std::size_t>(i)]);
  }
  double* const variables = own.data() + (plan.num_arrays() - num_shared) * kChunk;
  for (int u = 0; u < num_used; ++u) {
    arrays[static_cast<std::size_t>(used_[static_cast<std::size_t>(u)])] = variables + u * kChunk;
  }
  RunSteps* const run = RunStepsFor(ActiveIsa());
  for (Index chunk = begin; chunk < end; ++chunk) {
    const Index* const positions = positions_.data() + chunk * num_used * kChunk;
    for (int i = 0; i < num_used * kChunk; ++i) variables[i] = x[positions[i]];
    // Programs do not write to inputs.
    auto next = arrays.begin() + num_variables_;
    for (int d = 0; d < num_data_; ++d) {
      *next++ = const_cast<double*>(data_.data()) + (chunk * num_data_ + d) * kChunk;
    }
    for (int o = 0; o < plan.num_outputs(); ++o) *next++ = outputs + (chunk * plan.num_outputs() + o) * kChunk;
    run(plan.steps(), arrays.data());
  }
}

bool ProgramBatch::CopyRow(Index row, double* residuals, double** jacobians) const {
  const double* const outputs = outputs_.data() + row / kChunk * num_outputs_ * kChunk + row % kChunk;
  for (int r = 0; r < num_residuals_; ++r) residuals[r] = outputs[r * kChunk];
  if (jacobians == nullptr) return true;
  if (!dense_) {
    for (std::size_t b = 0; b < block_sizes_.size(); ++b) {
      if (jacobians[b] != nullptr) std::fill_n(jacobians[b], num_residuals_ * block_sizes_[b], 0.0);
    }
  }
  const double* derivative = outputs + num_residuals_ * kChunk;
  for (const Entry& entry : entries_) {
    if (jacobians[entry.block] != nullptr) jacobians[entry.block][entry.position] = *derivative;
    derivative += kChunk;
  }
  return true;
}

}  // namespace vesta::program
