// SPDX-License-Identifier: Apache-2.0
// The linearization of a batch of residual blocks. It stores one small dense Jacobian per residual block, all of the
// same size. It does not depend on the functor type, so it is compiled only once per size.
#pragma once

#include <algorithm>
#include <limits>
#include <type_traits>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "solver/internal/normal_equations/problem_adaptor.h"
#include "solver/internal/residual_block_layout.h"
#include "solver/loss.h"
#include "solver/problem_interfaces.h"

namespace vesta::residual_blocks_internal {

inline constexpr Index kGrain = 256;

template <int kResiduals, int kParameters, Backend B>
class Rows final : public Linearization<B>, public WithBlocks<B>, public WithStoredJacobian {
 public:
  using S = typename B::Scalar;
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;

  // Up to this number of blocks, sums over a parameter's columns need no Layout::transpose. Float sums always need it.
  static constexpr Index kMaxScattered = std::is_same_v<S, double> ? kGrain : -1;

  // layout and groups must outlive this object.
  Rows(const Layout& layout, int batch, const std::vector<BlockGroup>& groups)
      : layout_(layout), groups_(groups), blocks_(layout.blocks(batch)), transpose_(layout.transpose(batch)) {
    residuals_.ResizeForOverwrite(num_blocks() * kResiduals);
    jacobian_.ResizeForOverwrite(residuals_.size() * kParameters);
  }

  Index num_blocks() const { return static_cast<Index>(blocks_.size()); }
  // The b-th residual block of the batch: its index in the problem, its residuals, and column c of its Jacobian
  // (kResiduals values). The columns of a block are contiguous.
  Index block(Index b) const { return blocks_[static_cast<std::size_t>(b)]; }
  S* residual(Index b) { return residuals_.data() + b * kResiduals; }
  S* column(Index b, int c) { return jacobian_.data() + (b * kParameters + c) * kResiduals; }

  // Sets residuals and Jacobian of a block to NaN, because its functor returned false.
  void SetUndefined(Index b) {
    std::fill_n(residual(b), kResiduals, std::numeric_limits<S>::quiet_NaN());
    std::fill_n(column(b, 0), kResiduals * kParameters, std::numeric_limits<S>::quiet_NaN());
  }
  // Corrects residuals and Jacobian for the robust loss; null leaves them unchanged.
  void Correct(Index b, const Loss* loss) {
    if (loss == nullptr) return;
    const double s = SquaredNorm(residual(b), kResiduals);
    LossCorrection(loss->Evaluate(s), s).Apply(kResiduals, kParameters, residual(b), column(b, 0), 1, kResiduals);
  }

  Index num_residuals() const override { return residuals_.size(); }
  Index num_parameters() const override { return layout_.num_parameters(); }
  ConstVectorView residuals() const override { return residuals_.view(); }
  void ApplyJ(ConstVectorView v, VectorView u) override {
    ParallelFor(num_blocks(), kGrain, [&](Index b) {
      const Index* index = Parameters(b);
      for (int i = 0; i < kResiduals; ++i) {
        S sum = 0;
        for (int c = 0; c < kParameters; ++c) sum += column(b, c)[i] * v[index[c]];
        u[b * kResiduals + i] = sum;
      }
    });
  }
  void ApplyJT(ConstVectorView u, VectorView g) override {
    Gather(g, [&](Index b, const S* column) {
      double sum = 0;
      for (int i = 0; i < kResiduals; ++i) sum += static_cast<double>(column[i]) * u[b * kResiduals + i];
      return sum;
    });
  }
  void DiagJTJ(VectorView d) override {
    Gather(d, [](Index, const S* column) {
      double sum = 0;
      for (int i = 0; i < kResiduals; ++i) sum += static_cast<double>(column[i]) * column[i];
      return sum;
    });
  }
  void CopyJacobian(double* columns, Index leading) const override {
    const S* entry = jacobian_.data();
    for (Index b = 0; b < num_blocks(); ++b) {
      const Index* index = Parameters(b);
      for (int c = 0; c < kParameters; ++c) {
        double* const to = columns + index[c] * leading + b * kResiduals;
        for (int i = 0; i < kResiduals; ++i) to[i] = *entry++;
      }
    }
  }
  std::vector<BlockGroup> block_groups() const override { return groups_; }
  void BlockGram(BlockDiagonal<B>& out) override;

 private:
  const Index* Parameters(Index b) const { return layout_.parameters(block(b)); }
  // out_k = sum of term(b, column) over all columns of parameter k, where b is the residual block of the column. The
  // sum is in double precision and in the order of the blocks.
  template <class Term>
  void Gather(VectorView out, const Term& term) {
    if constexpr (kMaxScattered > 0) {
      if (num_blocks() <= kMaxScattered) {
        std::fill(out.begin(), out.end(), S(0));
        for (Index b = 0; b < num_blocks(); ++b) {
          const Index* index = Parameters(b);
          for (int c = 0; c < kParameters; ++c) out[index[c]] += term(b, column(b, c));
        }
        return;
      }
    }
    ParallelFor(out.size(), kGrain, [&](Index k) {
      double sum = 0;
      for (const auto& entry : transpose_.of(k)) sum += term(entry.block, column(entry.block, entry.column));
      out[k] = static_cast<S>(sum);
    });
  }

  const Layout& layout_;
  const std::vector<BlockGroup>& groups_;
  const std::vector<Index>& blocks_;
  const Transpose& transpose_;
  typename B::Vector residuals_;  // corrected for the loss, like jacobian_
  typename B::Vector jacobian_;   // one residual block after another, column by column
};

template <int kResiduals, int kParameters, Backend B>
void Rows<kResiduals, kParameters, B>::BlockGram(BlockDiagonal<B>& out) {
  // Position of each parameter in the diagonal blocks of H.
  struct Place {
    int group = 0, component = 0;
    Index diagonal_block = 0;
  };
  const std::vector<BlockGroup>& groups = out.groups();
  std::vector<Place> places(static_cast<std::size_t>(num_parameters()));
  for (std::size_t g = 0; g < groups.size(); ++g) {
    for (Index i = 0; i < groups[g].count; ++i) {
      for (int c = 0; c < groups[g].size; ++c) {
        places[static_cast<std::size_t>(groups[g].Parameter(i, c))] = {static_cast<int>(g), c, i};
      }
    }
  }
  for (Index b = 0; b < num_blocks(); ++b) {
    for (int c1 = 0; c1 < kParameters; ++c1) {
      const Place& row = places[static_cast<std::size_t>(Parameters(b)[c1])];
      for (int c2 = 0; c2 < kParameters; ++c2) {
        const Place& col = places[static_cast<std::size_t>(Parameters(b)[c2])];
        if (row.group != col.group || row.diagonal_block != col.diagonal_block || row.component < col.component)
          continue;
        S sum = 0;
        for (int i = 0; i < kResiduals; ++i) sum += column(b, c1)[i] * column(b, c2)[i];
        out.values(
            row.group)[PackedLower(row.component, col.component) * groups[static_cast<std::size_t>(row.group)].count +
                       row.diagonal_block] += sum;
      }
    }
  }
}

}  // namespace vesta::residual_blocks_internal
