// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/sparse_cholesky/block_normal_matrix.h"

#include <algorithm>
#include <numeric>

#include "kernels/core/parallel.h"
#include "solver/internal/linear/small_dense.h"

namespace vesta {

namespace {

constexpr Index kGrain = 64;

std::size_t At(Index i) { return static_cast<std::size_t>(i); }

// visit(row, larger cell, smaller cell) for each two free blocks of each residual block, in order.
template <class Visit>
void VisitPairs(const BlockStructure& structure, const Visit& visit) {
  for (std::size_t r = 0; r < structure.rows().size(); ++r) {
    const auto cells = structure.cells(structure.rows()[r]);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        const bool ascending = cells[k].free < cells[i].free;
        visit(static_cast<Index>(r), cells[ascending ? i : k], cells[ascending ? k : i]);
      }
    }
  }
}

std::size_t NumPairs(const BlockStructure& structure) {
  Index count = 0;
  for (const BlockRow& row : structure.rows()) count += Index{row.num_cells} * (row.num_cells - 1) / 2;
  return At(count);
}

}  // namespace

BlockNormalMatrix::BlockNormalMatrix(const BlockStructure& structure) {
  std::vector<int> sizes;
  for (const FreeBlock& block : structure.free_blocks()) sizes.push_back(block.size);
  std::vector<BlockPattern::Pair> pairs;
  std::vector<Term> terms;
  const std::size_t count = NumPairs(structure);
  pairs.reserve(count);
  terms.reserve(count);
  VisitPairs(structure, [&](Index row, const BlockCell& larger, const BlockCell& smaller) {
    pairs.push_back({larger.free, smaller.free});
    terms.push_back({row, larger.local, smaller.local});
  });
  pattern_ = std::make_shared<BlockPattern>(sizes, pairs);
  const std::vector<Index>& block_of_pair = pattern_->block_of_pair();
  first_term_.assign(At(pattern_->num_blocks()) + 1, 0);
  for (const Index block : block_of_pair) ++first_term_[At(block) + 1];
  std::partial_sum(first_term_.begin(), first_term_.end(), first_term_.begin());
  terms_.resize(terms.size());
  std::vector<std::size_t> next(first_term_.begin(), first_term_.end() - 1);
  for (std::size_t k = 0; k < terms.size(); ++k) terms_[next[At(block_of_pair[k])]++] = terms[k];
}

std::shared_ptr<const BlockMatrix> BlockNormalMatrix::Sum(const BlockJacobian& jacobian) {
  const std::shared_ptr<BlockMatrix> matrix = matrix_.Get([&] { return std::make_shared<BlockMatrix>(pattern_); });
  BlockMatrix& h = *matrix;
  const BlockPattern& pattern = *pattern_;
  const BlockStructure& structure = jacobian.structure();
  const auto add = [&](Index r, int a, int size_a, int b, int size_b, double* sum) {
    const BlockRow& row = structure.rows()[At(r)];
    const double* values = jacobian.row_values(r);
    small_dense::AddCrossProduct(values + a, values + b, row.width, row.num_residuals, size_a, size_b, sum);
  };
  // A row of blocks: that on the diagonal, and those left of it.
  ParallelFor(pattern.num_rows(), kGrain, [&](Index i) {
    const int size = pattern.size(i);
    double* diagonal = h.diagonal(i);
    std::fill_n(diagonal, size * size, 0.0);
    for (const BlockUse& use : structure.uses(static_cast<int>(i))) {
      add(use.row, use.local, size, use.local, size, diagonal);
    }
    for (const auto& [k, block] : pattern.neighbors(i)) {
      if (k > i) break;
      const int other = pattern.size(k);
      double* values = h.block(block);
      std::fill_n(values, size * other, 0.0);
      for (std::size_t t = first_term_[At(block)]; t < first_term_[At(block) + 1]; ++t) {
        add(terms_[t].row, terms_[t].larger, size, terms_[t].smaller, other, values);
      }
    }
  });
  return matrix;
}

double BlockNormalMatrix::Multiplications(const BlockStructure& structure) {
  double sum = 0;
  for (const BlockRow& row : structure.rows()) sum += 0.5 * row.num_residuals * row.width * (row.width + 1.0);
  return sum;
}

double BlockNormalMatrix::Bytes(const BlockStructure& structure) {
  // A pair's term, its block in the pattern, and what finding them takes.
  constexpr double kPair = 2 * sizeof(Term) + sizeof(BlockPattern::Pair) + 6 * sizeof(Index);
  return kPair * static_cast<double>(NumPairs(structure));
}

}  // namespace vesta
