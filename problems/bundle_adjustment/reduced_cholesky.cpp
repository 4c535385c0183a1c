// SPDX-License-Identifier: Apache-2.0
#include "problems/bundle_adjustment/reduced_cholesky.h"

#include <fmt/format.h>

#include <vector>

#include "kernels/core/parallel.h"
#include "problems/bundle_adjustment/kernels.h"

namespace vesta::bundle::internal {
namespace {

constexpr double kMaxBytes = 0x1p32;
// Multiplications to factorise for each entry of the matrix. A front does about ten in a nanosecond, a product with the
// matrix about one, so 1000 take as long as a hundred products.
constexpr double kMultiplicationsPerEntry = 1000;

}  // namespace

std::shared_ptr<ReducedCholeskyPlan> ReducedCholeskyPlan::Make(const ReducedPattern& pattern) {
  if (pattern.diagonal_only) return nullptr;
  const Index rows = pattern.row_first.size() - 1;
  std::vector<BlockPattern::Pair> pairs;
  for (Index i = 0; i < rows; ++i) {
    for (Index k = pattern.row_first[i] + 1; k < pattern.row_first[i + 1]; ++k) {
      pairs.push_back({i, Index{pattern.column[k]}});
    }
  }
  std::shared_ptr<ReducedCholeskyPlan> plan(new ReducedCholeskyPlan);
  const std::vector<int> sizes(static_cast<std::size_t>(rows), kCameraSize);
  plan->pattern_ = std::make_shared<const BlockPattern>(sizes, pairs);
  const auto entries = static_cast<double>(pattern.column.size()) * kCameraSize * kCameraSize;
  plan->cholesky_ = SparseCholesky::Plan(*plan->pattern_, kMaxBytes, kMultiplicationsPerEntry * entries);
  return plan->cholesky_ ? plan : nullptr;
}

std::string ReducedCholeskyPlan::description() const {
  return fmt::format("sparse Cholesky of {:.1f} MiB", cholesky_->bytes() / 0x1p20);
}

ReducedCholesky::ReducedCholesky(const ReducedCholeskyPlan& plan)
    : matrix_(plan.pattern_), no_damping_(plan.pattern_->num_scalars()), factor_(plan.cholesky_->Factor()) {}

void ReducedCholesky::Factorize(const ReducedPattern& pattern, const double* blocks) {
  const std::vector<Index>& block_of_pair = matrix_.pattern().block_of_pair();
  ParallelFor(pattern.row_first.size() - 1, 16, [&](Index i) {
    for (Index k = pattern.row_first[i]; k < pattern.row_first[i + 1]; ++k) {
      const double* from = blocks + kBlockSize * k;
      // Pairs are numbered without the diagonal blocks, one before each row's others.
      double* to = pattern.column[k] == i ? matrix_.diagonal(i)
                                          : matrix_.block(block_of_pair[static_cast<std::size_t>(k - i - 1)]);
      for (int r = 0; r < kCameraSize; ++r) {
        for (int c = 0; c < kCameraSize; ++c) to[kCameraSize * c + r] = from[kRowSize * r + kPointSize + c];
      }
    }
  });
  factor_->Factorize(matrix_, 0.0, no_damping_);
}

}  // namespace vesta::bundle::internal
