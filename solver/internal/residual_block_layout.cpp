// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/residual_block_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels/core/check.h"
#include "solver/internal/evaluation_faults.h"

namespace vesta::residual_blocks_internal {
namespace {

std::vector<Index> BlocksOf(int batch, int batches, Index count, BatchSplit split) {
  std::vector<Index> blocks;
  blocks.reserve(static_cast<std::size_t>(count / batches + 1));
  if (split == BatchSplit::kStrided) {
    for (Index i = batch; i < count; i += batches) blocks.push_back(i);
  } else {
    for (Index i = count * batch / batches; i < count * (batch + 1) / batches; ++i) blocks.push_back(i);
  }
  return blocks;
}

}  // namespace

Transpose::Transpose(Index num_parameters, int parameters_per_block, std::span<const Index> index,
                     std::span<const Index> blocks)
    : first_(static_cast<std::size_t>(num_parameters) + 1, 0) {
  const auto parameter = [&](std::size_t position, int c) {
    return static_cast<std::size_t>(index[static_cast<std::size_t>(blocks[position] * parameters_per_block + c)]);
  };
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    for (int c = 0; c < parameters_per_block; ++c) ++first_[parameter(b, c) + 1];
  }
  for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
  entries_.resize(first_.back());
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    for (int c = 0; c < parameters_per_block; ++c) {
      entries_[next[parameter(b, c)]++] = {static_cast<Index>(b), c};
    }
  }
}

Layout::Layout(Index num_parameters, Index num_blocks, int parameters_per_block, std::vector<Index> index,
               int num_batches, BatchSplit split, Index max_scattered)
    : num_parameters_(num_parameters), parameters_per_block_(parameters_per_block), index_(std::move(index)) {
  if (index_.empty()) {
    VESTA_CHECK(num_parameters >= parameters_per_block || num_blocks == 0, "functors read {} parameters, but x has {}",
                parameters_per_block, num_parameters);
    index_.resize(static_cast<std::size_t>(num_blocks * parameters_per_block));
    for (std::size_t k = 0; k < index_.size(); ++k) index_[k] = static_cast<Index>(k) % parameters_per_block;
  } else {
    CheckIndex(num_blocks);
  }
  VESTA_CHECK(num_batches >= 1, "num_batches is {}; choose 1 or more", num_batches);
  for (int batch = 0; batch < num_batches; ++batch) {
    batches_.push_back(BlocksOf(batch, num_batches, num_blocks, split));
    transposes_.emplace_back();
    if (static_cast<Index>(batches_.back().size()) > max_scattered) {
      transposes_.back() = Transpose(num_parameters, parameters_per_block, index_, batches_.back());
    }
  }
}

void Layout::CheckIndex(Index num_blocks) const {
  VESTA_CHECK(static_cast<Index>(index_.size()) == num_blocks * parameters_per_block_,
              "index has {} entries for {} functors of {} parameters", index_.size(), num_blocks,
              parameters_per_block_);
  for (const Index k : index_)
    VESTA_CHECK(k >= 0 && k < num_parameters_, "index {} is out of range; there are {} parameters", k, num_parameters_);
  for (Index block = 0; block < num_blocks; ++block) CheckDifferent(block);
}

void Layout::CheckDifferent(Index block) const {
  const Index* read = parameters(block);
  for (int c = 1; c < parameters_per_block_; ++c) {
    if (std::find(read, read + c, read[c]) != read + c) {
      Fail(kBadArgument, "functor {} reads parameter {} twice; give it different parameters", block, read[c]);
    }
  }
}

template <class S>
std::string Layout::DescribeNonFinite(Index block, std::span<const S> x, const Loss* loss, bool defined,
                                      std::span<const S> residuals, std::span<const S> jacobian) const {
  const Index* index = parameters(block);
  std::vector<double> read(static_cast<std::size_t>(parameters_per_block_));
  std::transform(index, index + parameters_per_block_, read.begin(),
                 [&](Index k) { return static_cast<double>(x[static_cast<std::size_t>(k)]); });
  const std::string at = fmt::format(", at parameters {}", DescribeNumbers(read));
  if (!defined) return fmt::format("residual block {} returns false{}", block, at);
  for (std::size_t r = 0; r < residuals.size(); ++r) {
    if (!std::isfinite(residuals[r])) {
      return fmt::format("{} {}{}", NameOf(block, static_cast<int>(r)), DescribeValue(residuals[r]), at);
    }
  }
  if (loss != nullptr) {
    const double square = SquaredNorm(residuals.data(), residuals.size());
    const double rho = loss->Evaluate(square).rho;
    if (!std::isfinite(rho)) return DescribeLossValue(block, square, rho) + at;
  }
  for (std::size_t k = 0; k < jacobian.size(); ++k) {
    if (std::isfinite(jacobian[k])) continue;
    return fmt::format("the derivative of {} by parameter {} {}{}",
                       NameOf(block, static_cast<int>(k % residuals.size())), index[k / residuals.size()],
                       DescribeValue(jacobian[k]), at);
  }
  return "";
}
template std::string Layout::DescribeNonFinite(Index, std::span<const float>, const Loss*, bool, std::span<const float>,
                                               std::span<const float>) const;
template std::string Layout::DescribeNonFinite(Index, std::span<const double>, const Loss*, bool,
                                               std::span<const double>, std::span<const double>) const;

std::string NameOf(Index block, int residual) {
  return fmt::format("residual {} of residual block {}", residual, block);
}

}  // namespace vesta::residual_blocks_internal
