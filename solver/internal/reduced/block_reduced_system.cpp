// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/reduced/block_reduced_system.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "kernels/core/parallel.h"
#include "solver/internal/linear/small_dense.h"

namespace vesta {

namespace {
using Part = BlockJacobian::Part;
// Memory for the partial sums of a product: 16 MiB, which fits in a large cache.
constexpr Index kPartialEntries = 1 << 21;
constexpr Index kMostTasks = 256;  // each allocates a pointer per kept block
}  // namespace

BlockReducedSystem::BlockReducedSystem(const BlockJacobian& jacobian, const Couplings& couplings, PlanOf plan_of)
    : jacobian_(jacobian),
      structure_(jacobian.structure()),
      couplings_(couplings),
      plan_of_(std::move(plan_of)),
      cross_product_(AddCrossProductFor(ActiveIsa())),
      kept_metric_(structure_.num_kept()),
      eliminated_(num_eliminated(), structure_.eliminated_groups()),
      num_ranges_(std::clamp<Index>(kPartialEntries / std::max<Index>(structure_.num_kept(), 1), 4, 64)),
      partial_(num_ranges_ * structure_.num_kept()) {
  Index values = 0;
  for (const FreeBlock& block : EliminatedBlocks()) {
    first_factor_.push_back(values);
    values += PackedLower(block.size, 0);
  }
  factors_.Resize(values);
  for (std::size_t r = 0; r < structure_.rows().size(); ++r) {
    if (structure_.rows()[r].eliminated_cell < 0) rows_alone_.push_back(static_cast<Index>(r));
  }
}

void BlockReducedSystem::SetDamping(double lambda, ConstVectorView metric) {
  lambda_ = lambda;
  B().Copy(metric.subspan(0, size()), kept_metric_);
  jacobian_.Gram(Part::kEliminated, eliminated_);
  eliminated_.AddToDiagonal(lambda, metric.subspan(size(), num_eliminated()));
  eliminated_.Factorize();
  const auto blocks = EliminatedBlocks();
  ParallelFor(static_cast<Index>(blocks.size()), 256, [&](Index e) {
    const FreeBlock& block = blocks[static_cast<std::size_t>(e)];
    const int group = block.group - blocks.front().group;
    const auto from = std::as_const(eliminated_).values(group);
    const Index count = eliminated_.groups()[static_cast<std::size_t>(group)].count;
    double* to = factors_.data() + first_factor_[static_cast<std::size_t>(e)];
    for (int k = 0; k < PackedLower(block.size, 0); ++k) to[k] = from[k * count + block.index_in_group];
  });
}

void BlockReducedSystem::PassRows(ConstVectorView x, ConstVectorView b, VectorView kept, VectorView eliminated) {
  const std::vector<BlockRow>& rows = structure_.rows();
  const auto blocks = EliminatedBlocks();
  const Index kept_size = size();
  // Calls body(values of the cell, row, cell) for each kept cell of a row.
  const auto each_kept = [&](Index r, const auto& body) {
    const BlockRow& row = rows[static_cast<std::size_t>(r)];
    const double* values = jacobian_.row_values(r);
    for (const BlockCell& cell : structure_.cells(row)) {
      if (cell.offset < kept_size) body(values + cell.local, row, cell);
    }
  };
  const auto kept_product = [&](Index r, double* u) {
    std::fill_n(u, rows[static_cast<std::size_t>(r)].num_residuals, 0.0);
    if (x.empty()) return;
    each_kept(r, [&](const double* values, const BlockRow& row, const BlockCell& cell) {
      small_dense::AddProduct(values, row.width, row.num_residuals, cell.size, x.data() + cell.offset, u);
    });
  };
  const auto add_kept = [&](Index r, const double* u, double* sum) {
    if (kept.empty()) return;
    each_kept(r, [&](const double* values, const BlockRow& row, const BlockCell& cell) {
      small_dense::AddTransposeProduct(values, row.width, row.num_residuals, cell.size, u, sum + cell.offset);
    });
  };
  const auto range = [&](Index count, Index i) {
    return std::pair(count * i / num_ranges_, count * (i + 1) / num_ranges_);
  };
  ParallelFor(num_ranges_, 1, [&](Index i) {
    double* const sum = partial_.data() + i * size();
    std::fill_n(sum, kept.empty() ? 0 : size(), 0.0);
    std::vector<double> y, u;
    const auto [alone_begin, alone_end] = range(static_cast<Index>(rows_alone_.size()), i);
    for (Index k = alone_begin; k < alone_end; ++k) {
      const Index r = rows_alone_[static_cast<std::size_t>(k)];
      u.resize(static_cast<std::size_t>(rows[static_cast<std::size_t>(r)].num_residuals));
      kept_product(r, u.data());
      add_kept(r, u.data(), sum);
    }
    const auto [begin, end] = range(static_cast<Index>(blocks.size()), i);
    for (Index e = begin; e < end; ++e) {
      const FreeBlock& block = blocks[static_cast<std::size_t>(e)];
      const auto uses = structure_.uses(structure_.num_kept_blocks() + static_cast<int>(e));
      const Index first = block.offset - size();
      // y = E^T F x, then y = C^-1 (b - y). u holds the rows' values one after another.
      y.assign(static_cast<std::size_t>(block.size), 0.0);
      u.clear();
      for (const BlockUse& use : uses) {
        const BlockRow& row = rows[static_cast<std::size_t>(use.row)];
        u.resize(u.size() + static_cast<std::size_t>(row.num_residuals));
        double* const own = u.data() + u.size() - row.num_residuals;
        kept_product(use.row, own);
        small_dense::AddTransposeProduct(jacobian_.row_values(use.row) + use.local, row.width, row.num_residuals,
                                         block.size, own, y.data());
      }
      for (int c = 0; c < block.size; ++c) {
        double& entry = y[static_cast<std::size_t>(c)];
        entry = (b.empty() ? 0.0 : b[first + c]) - entry;
      }
      const double* factor = factors_.data() + first_factor_[static_cast<std::size_t>(e)];
      small_dense::SolveLower(factor, block.size, y.data());
      small_dense::SolveLowerTranspose(factor, block.size, y.data());
      if (!eliminated.empty()) std::copy(y.begin(), y.end(), eliminated.data() + first);
      double* own = u.data();
      for (const BlockUse& use : uses) {
        const BlockRow& row = rows[static_cast<std::size_t>(use.row)];
        small_dense::AddProduct(jacobian_.row_values(use.row) + use.local, row.width, row.num_residuals, block.size,
                                y.data(), own);
        add_kept(use.row, own, sum);
        own += row.num_residuals;
      }
    }
  });
  ParallelFor(kept.size(), 1024, [&](Index k) {
    double sum = 0;
    for (Index i = 0; i < num_ranges_; ++i) sum += partial_[i * size() + k];
    kept[k] = sum;
  });
}

void BlockReducedSystem::ReduceRhs(ConstVectorView rhs, VectorView reduced) {
  PassRows({}, rhs.subspan(size(), num_eliminated()), reduced, {});
  B().Axpby(1.0, rhs.subspan(0, size()), -1.0, reduced);
}

void BlockReducedSystem::Apply(ConstVectorView x, VectorView y) {
  PassRows(x, {}, y, {});
  B().AddScaled(lambda_, kept_metric_, x, y);
}

void BlockReducedSystem::BackSubstitute(ConstVectorView rhs, VectorView step) {
  PassRows(step.subspan(0, size()), rhs.subspan(size(), num_eliminated()), {}, step.subspan(size(), num_eliminated()));
}

void BlockReducedSystem::ReduceCoupling(const Coupling& coupling, double* v) const {
  const int kept = Free(coupling.kept).size, gone = Eliminated(coupling.eliminated).size;
  std::fill_n(v, kept * gone, 0.0);
  for (const CouplingTerm& term : couplings_.terms(coupling)) {
    const BlockRow& row = structure_.rows()[static_cast<std::size_t>(term.row)];
    const double* values = jacobian_.row_values(term.row);
    cross_product_({values + term.eliminated, row.width, gone}, {values + term.kept, row.width, kept},
                   row.num_residuals, 1, v);
  }
  const double* factor = factors_.data() + first_factor_[static_cast<std::size_t>(coupling.eliminated)];
  small_dense::SolveLowerMatrix(factor, gone, kept, v);
}

void BlockReducedSystem::DiagonalBlocks(BlockDiagonal<B>& diagonal) {
  jacobian_.Gram(Part::kKept, diagonal);
  diagonal.AddToDiagonal(lambda_, kept_metric_);
  ParallelFor(structure_.num_kept_blocks(), 1, [&](Index k) {
    const FreeBlock& kept = Free(static_cast<int>(k));
    std::vector<double> v, fill(static_cast<std::size_t>(PackedLower(kept.size, 0)), 0.0);
    for (const Coupling& coupling : couplings_.of_kept(static_cast<int>(k))) {
      const int gone = Eliminated(coupling.eliminated).size;
      v.resize(static_cast<std::size_t>(kept.size) * static_cast<std::size_t>(gone));
      ReduceCoupling(coupling, v.data());
      small_dense::AddGram(v.data(), kept.size, gone, kept.size, fill.data());
    }
    const auto values = diagonal.values(kept.group);
    const Index count = diagonal.groups()[static_cast<std::size_t>(kept.group)].count;
    for (std::size_t i = 0; i < fill.size(); ++i)
      values[static_cast<Index>(i) * count + kept.index_in_group] -= fill[i];
  });
}

LinearOperator<BlockReducedSystem::B>* BlockReducedSystem::Factorize() {
  if (!plan_) return nullptr;
  if (!memory_) memory_ = plan_->GetMemory();
  const auto all = couplings_.all();
  ParallelFor(static_cast<Index>(all.size()), 256, [&](Index k) {
    const Coupling& coupling = all[static_cast<std::size_t>(k)];
    ReduceCoupling(coupling, memory_->couplings.data() + coupling.first_value);
  });
  const Index rows = structure_.num_kept_blocks();
  ParallelForChunks(rows, std::max<Index>(4, rows / kMostTasks), [&](Index begin, Index end) {
    std::vector<double*> block_of(static_cast<std::size_t>(rows));
    for (Index k = begin; k < end; ++k) FormRow(static_cast<int>(k), block_of, *memory_);
  });
  memory_->matrix.Factorize();
  return &memory_->matrix;
}

void BlockReducedSystem::FormRow(int k, std::vector<double*>& block_of, ReducedMatrixPlan::Memory& memory) const {
  const FreeBlock& own = Free(k);
  BlockMatrix& matrix = memory.matrix.matrix();
  for (const auto& [other, block] : matrix.pattern().neighbors(k)) {
    if (other > k) break;
    block_of[static_cast<std::size_t>(other)] = matrix.block(block);
    std::fill_n(matrix.block(block), own.size * Free(static_cast<int>(other)).size, 0.0);
  }
  double* const diagonal = matrix.diagonal(k);
  block_of[static_cast<std::size_t>(k)] = diagonal;
  std::fill_n(diagonal, own.size * own.size, 0.0);
  for (int c = 0; c < own.size; ++c) diagonal[c * own.size + c] = lambda_ * kept_metric_[own.offset + c];
  for (const BlockUse& use : structure_.uses(k)) {
    const BlockRow& row = structure_.rows()[static_cast<std::size_t>(use.row)];
    const double* values = jacobian_.row_values(use.row);
    for (const BlockCell& cell : structure_.cells(row)) {
      if (cell.free > k) continue;
      cross_product_({values + use.local, row.width, own.size}, {values + cell.local, row.width, cell.size},
                     row.num_residuals, 1, block_of[static_cast<std::size_t>(cell.free)]);
    }
  }
  for (const Coupling& coupling : couplings_.of_kept(k)) {
    const int gone = Eliminated(coupling.eliminated).size;
    const double* v = memory.couplings.data() + coupling.first_value;
    for (const CoupledKept& other : couplings_.of_eliminated(coupling.eliminated)) {
      if (other.kept > k) break;
      const int size = Free(other.kept).size;
      cross_product_({v, own.size, own.size}, {memory.couplings.data() + other.first_value, size, size}, gone, -1,
                     block_of[static_cast<std::size_t>(other.kept)]);
    }
  }
}

}  // namespace vesta
