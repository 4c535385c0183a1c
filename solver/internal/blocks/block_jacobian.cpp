// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/blocks/block_jacobian.h"

#include <vector>

#include "kernels/core/parallel.h"
#include "solver/internal/linear/small_dense.h"

namespace vesta {

namespace {
constexpr Index kRowGrain = 128, kBlockGrain = 16;
}  // namespace

BlockJacobian::Range BlockJacobian::RangeOf(Part part) const {
  const int kept = structure_.num_kept_blocks(), all = static_cast<int>(structure_.free_blocks().size());
  switch (part) {
    case Part::kKept:
      return {0, kept};
    case Part::kEliminated:
      return {kept, all};
    default:
      return {0, all};
  }
}

void BlockJacobian::Copy(double* columns, Index leading) const {
  for (std::size_t r = 0; r < structure_.rows().size(); ++r) {
    const BlockRow& row = structure_.rows()[r];
    const double* values = row_values(static_cast<Index>(r));
    for (const BlockCell& cell : structure_.cells(row)) {
      for (int c = 0; c < cell.size; ++c) {
        double* const to = columns + (cell.offset + c) * leading + row.residual_offset;
        for (int i = 0; i < row.num_residuals; ++i) to[i] = values[i * row.width + cell.local + c];
      }
    }
  }
}

void BlockJacobian::Apply(B::ConstVectorView v, B::VectorView u) const {
  ParallelFor(static_cast<Index>(structure_.rows().size()), kRowGrain, [&](Index r) {
    const BlockRow& row = At(r);
    const double* values = row_values(r);
    double* out = u.data() + row.residual_offset;
    for (int i = 0; i < row.num_residuals; ++i) out[i] = 0;
    for (const BlockCell& cell : structure_.cells(row)) {
      small_dense::AddProduct(values + cell.local, row.width, row.num_residuals, cell.size, v.data() + cell.offset,
                              out);
    }
  });
}

void BlockJacobian::ApplyTranspose(B::ConstVectorView u, B::VectorView g) const {
  ParallelFor(RangeOf(Part::kAll).end, kBlockGrain, [&](Index k) {
    const int free = static_cast<int>(k);
    const int size = Free(free).size;
    double* out = g.data() + Free(free).offset;
    for (int c = 0; c < size; ++c) out[c] = 0;
    for (const BlockUse& use : structure_.uses(free)) {
      const BlockRow& row = At(use.row);
      small_dense::AddTransposeProduct(row_values(use.row) + use.local, row.width, row.num_residuals, size,
                                       u.data() + row.residual_offset, out);
    }
  });
}

void BlockJacobian::SquaredColumns(B::VectorView d) const {
  const Range range = RangeOf(Part::kAll);
  ParallelFor(range.end, kBlockGrain, [&](Index free) {
    const FreeBlock& block = Free(static_cast<int>(free));
    double* out = d.data() + block.offset;
    for (int c = 0; c < block.size; ++c) out[c] = 0;
    for (const BlockUse& use : structure_.uses(static_cast<int>(free))) {
      const BlockRow& row = At(use.row);
      const double* entry = row_values(use.row) + use.local;
      for (int i = 0; i < row.num_residuals; ++i, entry += row.width) {
        for (int c = 0; c < block.size; ++c) out[c] += entry[c] * entry[c];
      }
    }
  });
}

void BlockJacobian::Gram(Part part, BlockDiagonal<B>& diagonal) const {
  const Range range = RangeOf(part);
  const int first_group = range.begin < range.end ? Free(range.begin).group : 0;
  ParallelForChunks(range.end - range.begin, kBlockGrain, [&](Index begin, Index end) {
    std::vector<double> gram;
    for (Index k = begin; k < end; ++k) {
      const int free = range.begin + static_cast<int>(k);
      const FreeBlock& block = Free(free);
      gram.assign(static_cast<std::size_t>(PackedLower(block.size, 0)), 0.0);
      for (const BlockUse& use : structure_.uses(free)) {
        const BlockRow& row = At(use.row);
        small_dense::AddGram(row_values(use.row) + use.local, row.width, row.num_residuals, block.size, gram.data());
      }
      const auto values = diagonal.values(block.group - first_group);
      const Index count = diagonal.groups()[static_cast<std::size_t>(block.group - first_group)].count;
      for (std::size_t i = 0; i < gram.size(); ++i) {
        values[static_cast<Index>(i) * count + block.index_in_group] = gram[i];
      }
    }
  });
}

}  // namespace vesta
