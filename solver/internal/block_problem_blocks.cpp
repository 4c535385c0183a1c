// SPDX-License-Identifier: Apache-2.0
// Adding, removing and querying the blocks of a BlockProblem, and their values.
#include <algorithm>
#include <limits>
#include <utility>

#include "kernels/core/check.h"
#include "solver/block_problem.h"
#include "solver/levenberg_marquardt.h"

namespace vesta {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void CheckManifold(const Manifold* manifold, int size) {
  VESTA_CHECK(!manifold || manifold->ambient_size() == size,
              "a manifold for {} numbers does not fit a block of {} numbers", manifold->ambient_size(), size);
}

// The number of a block's entries in a step.
int TangentSize(const Manifold* manifold, bool constant, int size) {
  if (constant) return 0;
  return manifold ? manifold->tangent_size() : size;
}

}  // namespace

const ParameterBlock& BlockProblem::Parameter(int block) const {
  VESTA_CHECK(block >= 0 && block < static_cast<int>(parameters_.size()),
              "there is no parameter block {}; the problem has {}", block, num_parameter_blocks());
  const ParameterBlock& parameter = parameters_[static_cast<std::size_t>(block)];
  VESTA_CHECK(parameter.ambient_size > 0, "parameter block {} was removed", block);
  return parameter;
}

std::size_t BlockProblem::CheckedTerm(Index residual_block) const {
  VESTA_CHECK(residual_block >= 0 && residual_block < static_cast<Index>(residuals_.size()),
              "there is no residual block {}; the problem has {}", residual_block, num_residual_blocks());
  const auto term = static_cast<std::size_t>(residual_block);
  VESTA_CHECK(residuals_[term].num_residuals > 0, "residual block {} was removed", residual_block);
  return term;
}

int BlockProblem::AddParameterBlock(int size, std::shared_ptr<const Manifold> manifold) {
  VESTA_CHECK(size > 0, "the size of a parameter block is {}; choose 1 or more", size);
  CheckManifold(manifold.get(), size);
  Changed();
  std::vector<int>& removed = removed_[size];
  int block = static_cast<int>(parameters_.size());
  if (!removed.empty()) {
    block = removed.back();
    removed.pop_back();
  } else {
    parameters_.push_back({.ambient_offset = num_parameters_});
    manifolds_.emplace_back();
    constant_.push_back(false);
    caller_memory_.push_back(nullptr);
    num_parameters_ += size;
    values_.resize(static_cast<std::size_t>(num_parameters_));
    if (has_bounds()) {
      lower_.resize(static_cast<std::size_t>(num_parameters_), -kInfinity);
      upper_.resize(static_cast<std::size_t>(num_parameters_), kInfinity);
    }
  }
  ParameterBlock& parameter = parameters_[static_cast<std::size_t>(block)];
  parameter.ambient_size = parameter.tangent_size = size;
  ++num_parameter_blocks_;
  if (manifold) SetManifold(block, std::move(manifold));
  return block;
}

int BlockProblem::AddParameterBlock(double* values, int size, std::shared_ptr<const Manifold> manifold) {
  VESTA_CHECK(values != nullptr, "the values of a parameter block are null");
  const auto known = block_of_.find(values);
  VESTA_CHECK(known == block_of_.end(), "these values belong to parameter block {} already", known->second);
  const int block = AddParameterBlock(size, std::move(manifold));
  caller_memory_[static_cast<std::size_t>(block)] = values;
  block_of_[values] = block;
  return block;
}

void BlockProblem::RemoveParameterBlock(int block) {
  const ParameterBlock removed = Parameter(block);
  for (const Index residual_block : residual_blocks_of(block)) RemoveResidualBlock(residual_block);
  Changed();
  const auto k = static_cast<std::size_t>(block);
  for (int entry = 0; has_bounds() && entry < removed.ambient_size; ++entry) {
    SetBounds(block, entry, -kInfinity, kInfinity);
  }
  if (caller_memory_[k]) block_of_.erase(caller_memory_[k]);
  caller_memory_[k] = nullptr;
  std::fill_n(values_.data() + removed.ambient_offset, removed.ambient_size, 0.0);
  manifolds_[k] = nullptr;
  constant_[k] = false;
  parameters_[k].ambient_size = parameters_[k].tangent_size = 0;
  removed_[removed.ambient_size].push_back(block);
  --num_parameter_blocks_;
}

void BlockProblem::SetManifold(int block, std::shared_ptr<const Manifold> manifold) {
  const int size = Parameter(block).ambient_size;
  CheckManifold(manifold.get(), size);
  Changed();
  const auto k = static_cast<std::size_t>(block);
  manifolds_[k] = std::move(manifold);
  parameters_[k].tangent_size = TangentSize(manifolds_[k].get(), constant_[k], size);
}

void BlockProblem::SetConstant(int block, bool constant) {
  const int size = Parameter(block).ambient_size;
  Changed();
  const auto k = static_cast<std::size_t>(block);
  constant_[k] = constant;
  parameters_[k].tangent_size = TangentSize(manifolds_[k].get(), constant, size);
}

std::size_t BlockProblem::EntryOf(int block, int entry) const {
  VESTA_CHECK(entry >= 0 && entry < Parameter(block).ambient_size, "there is no entry {} in block {}", entry, block);
  return static_cast<std::size_t>(Parameter(block).ambient_offset + entry);
}

void BlockProblem::SetBounds(int block, int entry, double lower, double upper) {
  const std::size_t k = EntryOf(block, entry);
  if (!(lower <= upper)) {
    Fail(kBadArgument, "block {}, entry {}: the lower bound {} is above the upper bound {}", block, entry, lower,
         upper);
  }
  lower_.resize(static_cast<std::size_t>(num_parameters_), -kInfinity);
  upper_.resize(static_cast<std::size_t>(num_parameters_), kInfinity);
  lower_[k] = lower;
  upper_[k] = upper;
}

Index BlockProblem::AddResidualBlock(std::shared_ptr<const CostFunction> cost, std::shared_ptr<const Loss> loss,
                                     std::span<const int> blocks) {
  VESTA_CHECK(cost != nullptr, "the cost function of residual block {} is null", num_residual_blocks());
  VESTA_CHECK(cost->num_residuals() > 0, "the cost function of residual block {} has {} residuals; give it 1 or more",
              num_residual_blocks(), cost->num_residuals());
  const std::span<const int> sizes = cost->block_sizes();
  VESTA_CHECK(sizes.size() == blocks.size(), "the cost function needs {} parameter blocks, not {}", sizes.size(),
              blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    VESTA_CHECK(Parameter(blocks[i]).ambient_size == sizes[i],
                "argument {} of the cost function has {} numbers, but block {} has {}", i, sizes[i], blocks[i],
                Parameter(blocks[i]).ambient_size);
    VESTA_CHECK(std::find(blocks.begin(), blocks.begin() + static_cast<std::ptrdiff_t>(i), blocks[i]) ==
                    blocks.begin() + static_cast<std::ptrdiff_t>(i),
                "block {} is used twice in one residual block", blocks[i]);
  }
  Changed();
  users_.clear();
  const std::size_t term = residuals_.Add({cost->num_residuals(), blocks});
  if (term == terms_.size()) terms_.emplace_back();
  terms_[term] = {std::move(cost), std::move(loss)};
  return static_cast<Index>(term);
}

std::vector<Index> BlockProblem::AddAll(const std::shared_ptr<const void>& owner,
                                        std::span<const CostFunction* const> costs, std::span<const int> blocks,
                                        const std::shared_ptr<const Loss>& loss) {
  std::size_t needed = 0;
  for (const CostFunction* cost : costs) needed += cost->block_sizes().size();
  VESTA_CHECK(needed == blocks.size(), "the cost functions need {} parameter blocks, not {}", needed, blocks.size());
  ReserveResidualBlocks(residuals_.size() + costs.size());
  std::vector<Index> added;
  added.reserve(costs.size());
  for (const CostFunction* cost : costs) {
    const std::size_t count = cost->block_sizes().size();
    added.push_back(AddResidualBlock(std::shared_ptr<const CostFunction>(owner, cost), loss, blocks.first(count)));
    blocks = blocks.subspan(count);
  }
  return added;
}

void BlockProblem::RemoveResidualBlock(Index residual_block) {
  const std::size_t term = CheckedTerm(residual_block);
  Changed();
  residuals_.Remove(term);
  terms_[term] = {};
}

void BlockProblem::ReserveResidualBlocks(std::size_t count) {
  residuals_.Reserve(count);
  terms_.reserve(count);
}

bool BlockProblem::has_parameter_block(int block) const {
  return block >= 0 && block < static_cast<int>(parameters_.size()) &&
         parameters_[static_cast<std::size_t>(block)].ambient_size > 0;
}

bool BlockProblem::has_residual_block(Index residual_block) const {
  return residual_block >= 0 && residual_block < static_cast<Index>(residuals_.size()) &&
         residuals_[static_cast<std::size_t>(residual_block)].num_residuals > 0;
}

std::vector<int> BlockProblem::parameter_blocks() const {
  std::vector<int> blocks;
  for (int block = 0; block < static_cast<int>(parameters_.size()); ++block) {
    if (has_parameter_block(block)) blocks.push_back(block);
  }
  return blocks;
}

std::vector<Index> BlockProblem::residual_blocks() const {
  std::vector<Index> blocks;
  for (Index block = 0; block < static_cast<Index>(residuals_.size()); ++block) {
    if (has_residual_block(block)) blocks.push_back(block);
  }
  return blocks;
}

const std::shared_ptr<const Manifold>& BlockProblem::manifold(int block) const {
  Parameter(block);  // throws if there is no such block
  return manifolds_[static_cast<std::size_t>(block)];
}

bool BlockProblem::is_constant(int block) const {
  Parameter(block);
  return constant_[static_cast<std::size_t>(block)];
}

double BlockProblem::lower_bound(int block, int entry) const {
  const std::size_t k = EntryOf(block, entry);
  return has_bounds() ? lower_[k] : -kInfinity;
}

double BlockProblem::upper_bound(int block, int entry) const {
  const std::size_t k = EntryOf(block, entry);
  return has_bounds() ? upper_[k] : kInfinity;
}

int BlockProblem::FindParameterBlock(const double* values) const {
  const auto found = block_of_.find(values);
  VESTA_CHECK(found != block_of_.end(), "this address is not a parameter block of the problem");
  return found->second;
}

const std::shared_ptr<const CostFunction>& BlockProblem::cost_function(Index residual_block) const {
  return terms_[CheckedTerm(residual_block)].cost;
}

const std::shared_ptr<const Loss>& BlockProblem::loss(Index residual_block) const {
  return terms_[CheckedTerm(residual_block)].loss;
}

std::span<const int> BlockProblem::parameter_blocks_of(Index residual_block) const {
  return residuals_[CheckedTerm(residual_block)].parameters;
}

std::vector<Index> BlockProblem::residual_blocks_of(int block) const {
  Parameter(block);
  if (users_.empty()) {
    users_.resize(parameters_.size());
    for (std::size_t term = 0; term < residuals_.size(); ++term) {
      for (const int p : residuals_[term].parameters) {
        users_[static_cast<std::size_t>(p)].push_back(static_cast<Index>(term));
      }
    }
  }
  std::vector<Index> users;
  if (static_cast<std::size_t>(block) >= users_.size()) return users;  // added later than all residual blocks
  for (const Index user : users_[static_cast<std::size_t>(block)]) {
    if (has_residual_block(user)) users.push_back(user);
  }
  return users;
}

std::span<const double> BlockProblem::Get(int block) const {
  const int size = parameter_block_size(block);  // throws if there is no such block
  const double* const memory = caller_memory_[static_cast<std::size_t>(block)];
  return {memory ? memory : values_.data() + offset(block), static_cast<std::size_t>(size)};
}

void BlockProblem::Set(int block, const double* values) {
  const int size = parameter_block_size(block);
  double* const memory = caller_memory_[static_cast<std::size_t>(block)];
  std::copy_n(values, size, memory ? memory : values_.data() + offset(block));
}

BlockProblem::B::Vector BlockProblem::Gather() const {
  B::Vector x(num_parameters_);
  std::copy(values_.begin(), values_.end(), x.data());
  for (const auto& [values, block] : block_of_)
    std::copy_n(values, parameter_block_size(block), x.data() + offset(block));
  return x;
}

void BlockProblem::Scatter(ConstVectorView x) {
  CheckSize(x);
  for (const int block : parameter_blocks()) Set(block, x.data() + offset(block));
}

LmSummary SolveLm(BlockProblem& problem, const LmOptions& options,
                  const IterationCallback<CpuBackend<double>>& callback) {
  CpuBackend<double>::Vector x = problem.Gather();
  LmSummary summary = SolveLm<CpuBackend<double>>(problem, x.view(), options, callback);
  problem.Scatter(x);
  return summary;
}

}  // namespace vesta
