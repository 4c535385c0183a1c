// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/sparse_cholesky/block_matrix.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "solver/internal/linear/cross_product.h"
#include "solver/internal/linear/small_dense.h"

namespace vesta {

namespace {
constexpr Index kGrain = 128;
}

BlockPattern::BlockPattern(std::span<const int> sizes, std::span<const Pair> pairs)
    : sizes_(sizes.begin(), sizes.end()), first_(sizes.size() + 1, 0), block_of_pair_(pairs.size()) {
  offsets_.push_back(0);
  diagonal_values_.push_back(0);
  for (const int size : sizes_) {
    VESTA_CHECK(size >= 1, "the size of a row of blocks is {}; it must be 1 or more", size);
    offsets_.push_back(offsets_.back() + size);
    diagonal_values_.push_back(diagonal_values_.back() + Index{size} * size);
  }
  if (!sizes_.empty() && std::all_of(sizes_.begin(), sizes_.end(), [&](int size) { return size == sizes_.front(); })) {
    uniform_size_ = sizes_.front();
  }

  // By larger row, then smaller row: the order of the blocks.
  const auto row_of = [&](std::size_t k) { return std::max(pairs[k].a, pairs[k].b); };
  const auto col_of = [&](std::size_t k) { return std::min(pairs[k].a, pairs[k].b); };
  std::vector<std::size_t> begin(sizes_.size() + 1, 0), order(pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    VESTA_CHECK(col_of(k) >= 0 && row_of(k) < num_rows() && col_of(k) < row_of(k), "block ({}, {}) of {} rows",
                row_of(k), col_of(k), num_rows());
    ++begin[At(row_of(k)) + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  for (std::size_t k = 0; k < pairs.size(); ++k) order[next[At(row_of(k))]++] = k;
  std::vector<std::pair<Index, Index>> blocks;
  for (std::size_t row = 0; row < sizes_.size(); ++row) {
    std::sort(order.begin() + static_cast<std::ptrdiff_t>(begin[row]),
              order.begin() + static_cast<std::ptrdiff_t>(begin[row + 1]),
              [&](std::size_t i, std::size_t k) { return col_of(i) < col_of(k); });
    for (std::size_t i = begin[row]; i < begin[row + 1]; ++i) {
      const std::pair<Index, Index> key(static_cast<Index>(row), col_of(order[i]));
      if (blocks.empty() || blocks.back() != key) blocks.push_back(key);
      block_of_pair_[order[i]] = static_cast<Index>(blocks.size()) - 1;
    }
  }

  block_values_.push_back(0);
  for (const auto& [row, col] : blocks) {
    block_values_.push_back(block_values_.back() + Index{size(row)} * size(col));
    ++first_[At(row) + 1];
    ++first_[At(col) + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  neighbors_.resize(first_.back());
  // Blocks are sorted by row, then column. So each row lists its smaller neighbours first, then the larger ones,
  // ascending.
  next.assign(first_.begin(), first_.end() - 1);
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    neighbors_[next[At(blocks[k].first)]++] = {blocks[k].second, static_cast<Index>(k)};
  }
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    neighbors_[next[At(blocks[k].second)]++] = {blocks[k].first, static_cast<Index>(k)};
  }
}

bool BlockPattern::HasSamePlaces(const BlockPattern& other) const {
  return first_ == other.first_ && neighbors_ == other.neighbors_;
}

BlockMatrix::BlockMatrix(std::shared_ptr<const BlockPattern> pattern)
    : pattern_(std::move(pattern)),
      diagonal_(pattern_->diagonal_value(pattern_->num_rows())),
      blocks_(pattern_->block_value(pattern_->num_blocks())) {}

void BlockMatrix::Apply(HostSpan<const double> x, HostSpan<double> y) const {
  switch (pattern_->uniform_size()) {
    case 3:
      return ApplyUniform<3>(x.data(), y.data());
    case 6:
      return ApplyUniform<6>(x.data(), y.data());
    default:
      return ApplyMixed(x.data(), y.data());
  }
}

template <int D>
void BlockMatrix::ApplyUniform(const double* x, double* y) const {
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
  ParallelFor(pattern_->num_rows(), kGrain, [&](Index row) {
    const std::span<const BlockPattern::Neighbor> neighbors = pattern_->neighbors(row);
    const double* blocks = blocks_.data();
    double sum[D] = {};
    std::size_t k = 0;
    for (; k < neighbors.size() && neighbors[k].row < row; ++k)
      add(blocks + D * D * neighbors[k].block, x + D * neighbors[k].row, sum);
    add(diagonal_.data() + D * D * row, x + D * row, sum);
    for (; k < neighbors.size(); ++k) {
      add_transposed(blocks + D * D * neighbors[k].block, x + D * neighbors[k].row, sum);
    }
    std::copy(sum, sum + D, y + D * row);
  });
}

void BlockMatrix::ApplyMixed(const double* x, double* y) const {
  const BlockPattern& pattern = *pattern_;
  ParallelFor(pattern.num_rows(), kGrain, [&](Index row) {
    const std::span<const BlockPattern::Neighbor> neighbors = pattern.neighbors(row);
    const int size = pattern.size(row);
    double* sum = y + pattern.offset(row);
    std::fill_n(sum, size, 0.0);
    std::size_t k = 0;
    for (; k < neighbors.size() && neighbors[k].row < row; ++k) {
      const auto [col, number] = neighbors[k];
      small_dense::AddProduct(block(number), pattern.size(col), size, pattern.size(col), x + pattern.offset(col), sum);
    }
    small_dense::AddProduct(diagonal(row), size, size, size, x + pattern.offset(row), sum);
    for (; k < neighbors.size(); ++k) {
      const auto [col, number] = neighbors[k];
      small_dense::AddTransposeProduct(block(number), size, pattern.size(col), size, x + pattern.offset(col), sum);
    }
  });
}

namespace {

constexpr Index kNormalGrain = 64;

std::size_t At(Index i) { return static_cast<std::size_t>(i); }

// Calls visit(row, larger cell, smaller cell) for every two cells of each residual block, in order.
template <class CellsOf, class Visit>
void VisitPairs(const BlockStructure& structure, CellsOf& cells_of, const Visit& visit) {
  for (std::size_t r = 0; r < structure.rows().size(); ++r) {
    const std::span<const BlockCell> cells = cells_of(structure.rows()[r]);
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

BlockNormalMatrix::BlockNormalMatrix(const BlockStructure& structure)
    : BlockNormalMatrix(structure, NumPairs(structure), [&](const BlockRow& row) { return structure.cells(row); }) {}

BlockNormalMatrix::BlockNormalMatrix(const BlockJacobian& jacobian)
    : BlockNormalMatrix(jacobian.structure(), 0, [&, nonzero = std::vector<BlockCell>()](const BlockRow& row) mutable {
        const double* values = jacobian.values(row);
        nonzero.clear();
        for (const BlockCell& cell : jacobian.structure().cells(row)) {
          bool zero = true;
          for (int i = 0; i < row.num_residuals && zero; ++i) {
            const double* const entries = values + Index{i} * row.width + cell.local;
            zero = std::all_of(entries, entries + cell.size, [](double entry) { return entry == 0; });
          }
          if (!zero) nonzero.push_back(cell);
        }
        return std::span<const BlockCell>(nonzero);
      }) {}

template <class CellsOf>
BlockNormalMatrix::BlockNormalMatrix(const BlockStructure& structure, std::size_t reserve, CellsOf cells_of) {
  std::vector<int> sizes;
  for (const FreeBlock& block : structure.free_blocks()) sizes.push_back(block.size);
  std::vector<BlockPattern::Pair> pairs;
  std::vector<Term> terms;
  pairs.reserve(reserve);
  terms.reserve(reserve);
  VisitPairs(structure, cells_of, [&](Index row, const BlockCell& larger, const BlockCell& smaller) {
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
  AddCrossProduct* const cross_product = AddCrossProductFor(ActiveIsa());
  const auto add = [&](Index r, int a, int size_a, int b, int size_b, double* sum) {
    const BlockRow& row = structure.rows()[At(r)];
    const double* values = jacobian.row_values(r);
    cross_product({values + a, row.width, size_a}, {values + b, row.width, size_b}, row.num_residuals, 1, sum);
  };
  // One row of blocks: the diagonal block and the blocks left of it.
  ParallelFor(pattern.num_rows(), kNormalGrain, [&](Index i) {
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
  // The term of a pair, its block in the pattern, and temporary memory.
  constexpr double kPair = 2 * sizeof(Term) + sizeof(BlockPattern::Pair) + 6 * sizeof(Index);
  return kPair * static_cast<double>(NumPairs(structure));
}

VESTA_DECLARE_PER_ISA(AddCrossProduct CompiledAddCrossProduct;)

AddCrossProduct* AddCrossProductFor(Isa isa) { return VESTA_OF_ISA(isa, CompiledAddCrossProduct); }

}  // namespace vesta
