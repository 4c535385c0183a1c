// SPDX-License-Identifier: Apache-2.0
// Derivatives of a functor of several parameter blocks, for cost functions with automatic derivatives.
#pragma once

#include <algorithm>
#include <cstddef>
#include <type_traits>

#include "kernels/math/derivatives.h"
#include "solver/internal/derivative_passes.h"

namespace vesta {

// Computes residuals and Jacobians as CostFunction::Evaluate does; jacobians is not null. call(blocks, residuals):
// calls the functor, with pointers to dual numbers or to doubles, and returns its result. The blocks of dual numbers
// are adjacent in memory.
//
// work: the sizes and the memory, as members that may be constants and arrays of a fixed size:
//   num_blocks(), size(b), num_residuals()
//   parameters[], residuals[]: dual numbers, of all blocks and of all residuals
//   blocks[]: a pointer to const dual numbers per block; columns[]: a pointer to a dual number per parameter
template <class Work, class Call>
bool DifferentiateBlocks(Work& work, const double* const* parameters, double* residuals, double** jacobians,
                         const Call& call) {
  using D = std::remove_reference_t<decltype(work.parameters[0])>;
  std::size_t num_columns = 0;  // parameters whose derivatives are needed
  for (std::size_t b = 0, k = 0; b < work.num_blocks(); ++b) {
    work.blocks[b] = work.parameters.data() + k;
    for (int i = 0; i < work.size(b); ++i, ++k) {
      work.parameters[k] = D(parameters[b][i]);
      if (jacobians[b] != nullptr) work.columns[num_columns++] = work.parameters.data() + k;
    }
  }
  if (num_columns == 0) return call(parameters, residuals);
  MarkUnwritten(work.num_residuals(), work.residuals.data());
  return DifferentiateInPasses(
      static_cast<int>(num_columns), [&](int c) -> D& { return *work.columns[static_cast<std::size_t>(c)]; },
      [&] { return call(work.blocks.data(), work.residuals.data()); },
      [&](int first, int count) {
        const auto residual = [&](int row) -> D& { return work.residuals[static_cast<std::size_t>(row)]; };
        for (int row = 0; row < work.num_residuals(); ++row) residuals[row] = residual(row).a;
        int begin = 0;  // column of the block's first parameter
        for (std::size_t b = 0; b < work.num_blocks(); ++b) {
          if (jacobians[b] == nullptr) continue;
          const int end = begin + work.size(b);
          for (int row = 0; row < work.num_residuals(); ++row) {
            for (int c = std::max(begin, first); c < std::min(end, first + count); ++c) {
              jacobians[b][row * work.size(b) + c - begin] = DerivativeOf(residual(row), c - first);
            }
          }
          begin = end;
        }
      });
}

}  // namespace vesta
