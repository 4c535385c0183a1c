#include "problems/pose_graph/block_matrix.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::pose_graph {

BlockPattern::BlockPattern(Index num_rows, std::span<const Pair> pairs)
    : first_(static_cast<std::size_t>(num_rows) + 1, 0), block_of_pair_(pairs.size()) {
  const auto key = [&](std::size_t k) {
    return std::pair(std::max(pairs[k].a, pairs[k].b), std::min(pairs[k].a, pairs[k].b));
  };
  std::vector<std::size_t> order(pairs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t k) { return key(i) < key(k); });
  std::vector<std::pair<Index, Index>> blocks;
  for (const std::size_t k : order) {
    const auto [row, col] = key(k);
    VESTA_CHECK(col >= 0 && row < num_rows && col < row, "block ({}, {}) of {} rows", row, col, num_rows);
    if (blocks.empty() || blocks.back() != key(k)) blocks.push_back(key(k));
    block_of_pair_[k] = static_cast<Index>(blocks.size()) - 1;
  }
  for (const auto& [row, col] : blocks) {
    ++first_[static_cast<std::size_t>(row) + 1];
    ++first_[static_cast<std::size_t>(col) + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  neighbors_.resize(first_.back());
  // Blocks are sorted by row, then column: first each row's smaller neighbours, ascending, then its larger ones.
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    neighbors_[next[static_cast<std::size_t>(blocks[k].first)]++] = {blocks[k].second, static_cast<Index>(k)};
  }
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    neighbors_[next[static_cast<std::size_t>(blocks[k].second)]++] = {blocks[k].first, static_cast<Index>(k)};
  }
}

BlockMatrix::BlockMatrix(std::shared_ptr<const BlockPattern> pattern, int block_size)
    : pattern_(std::move(pattern)),
      block_size_(block_size),
      diagonal_(pattern_->num_rows() * block_size * block_size),
      blocks_(pattern_->num_blocks() * block_size * block_size) {
  VESTA_CHECK(block_size == 3 || block_size == 6, "blocks of {} rows", block_size);
}

void BlockMatrix::Apply(HostSpan<const double> x, HostSpan<double> y) const {
  if (block_size_ == 3) {
    ApplyBlocks<3>(x.data(), y.data());
  } else {
    ApplyBlocks<6>(x.data(), y.data());
  }
}

template <int D>
void BlockMatrix::ApplyBlocks(const double* x, double* y) const {
  const auto add = [](const double* block, const double* v, double* sum) {
    for (int i = 0; i < D; ++i) {
      for (int k = 0; k < D; ++k) sum[i] += block[D * i + k] * v[k];
    }
  };
  const auto add_transposed = [](const double* block, const double* v, double* sum) {
    for (int k = 0; k < D; ++k) {
      for (int i = 0; i < D; ++i) sum[i] += block[D * k + i] * v[k];
    }
  };
  constexpr Index kGrain = 128;
  ParallelFor(pattern_->num_rows(), kGrain, [&](Index row) {
    const std::span<const BlockPattern::Neighbor> neighbors = pattern_->neighbors(row);
    double sum[D] = {};
    std::size_t k = 0;
    for (; k < neighbors.size() && neighbors[k].row < row; ++k)
      add(block(neighbors[k].block), x + D * neighbors[k].row, sum);
    add(diagonal(row), x + D * row, sum);
    for (; k < neighbors.size(); ++k) add_transposed(block(neighbors[k].block), x + D * neighbors[k].row, sum);
    std::copy(sum, sum + D, y + D * row);
  });
}

}  // namespace vesta::pose_graph
