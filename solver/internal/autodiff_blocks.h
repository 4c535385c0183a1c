// SPDX-License-Identifier: Apache-2.0
// Derivatives of a functor of several parameter blocks, for cost functions with automatic derivatives.
#pragma once

#include <algorithm>
#include <span>

#include "kernels/math/derivatives.h"
#include "solver/internal/derivative_passes.h"

namespace vesta {

// Work memory of DifferentiateBlocks. D is a dual number.
template <class D>
struct AutoDiffMemory {
  D* parameters;     // of all blocks
  D* residuals;      // num_residuals
  const D** blocks;  // per block
  D** columns;       // per parameter
};

// Computes residuals and Jacobians as CostFunction::Evaluate does; jacobians is not null. call(blocks, residuals):
// calls the functor, with pointers to dual numbers or to doubles, and returns its result. The blocks of dual numbers
// are adjacent in memory. Inlined, so that the compiler unrolls loops over sizes that are constants.
template <class D, class Call>
[[gnu::always_inline]] inline bool DifferentiateBlocks(std::span<const int> sizes, int num_residuals,
                                                       const AutoDiffMemory<D>& memory, const double* const* parameters,
                                                       double* residuals, double** jacobians, const Call& call) {
  int num_columns = 0;  // parameters whose derivatives are needed
  D* next = memory.parameters;
  for (std::size_t b = 0; b < sizes.size(); ++b) {
    memory.blocks[b] = next;
    for (int i = 0; i < sizes[b]; ++i, ++next) {
      *next = D(parameters[b][i]);
      if (jacobians[b] != nullptr) memory.columns[num_columns++] = next;
    }
  }
  if (num_columns == 0) return call(parameters, residuals);
  MarkUnwritten(num_residuals, memory.residuals);
  return DifferentiateInPasses(
      num_columns, [&](int c) -> D& { return *memory.columns[c]; },
      [&] { return call(memory.blocks, memory.residuals); },
      [&](int first, int count) {
        for (int row = 0; row < num_residuals; ++row) residuals[row] = memory.residuals[row].a;
        int begin = 0;  // column of the block's first parameter
        for (std::size_t b = 0; b < sizes.size(); ++b) {
          if (jacobians[b] == nullptr) continue;
          const int end = begin + sizes[b];
          for (int row = 0; row < num_residuals; ++row) {
            for (int c = std::max(begin, first); c < std::min(end, first + count); ++c) {
              jacobians[b][row * sizes[b] + c - begin] = DerivativeOf(memory.residuals[row], c - first);
            }
          }
          begin = end;
        }
      });
}

}  // namespace vesta
