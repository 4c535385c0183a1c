// SPDX-License-Identifier: Apache-2.0
// J column by column, for problems small enough to hold it.
#pragma once

#include <span>
#include <vector>

#include "solver/internal/normal_equations/problem_adaptor.h"

namespace vesta {

struct DenseJacobian {
  int rows = 0, cols = 0;
  std::vector<double> jacobian = {};   // column after column: the batches' J stacked
  std::vector<double> residuals = {};  // theirs
};

// By cols products with unit vectors. Columns whose mask is 0 are zero; an empty mask masks none.
template <Backend B>
DenseJacobian MakeDenseJacobian(B& backend, std::span<LinearizationAdaptor<B>* const> batches,
                                typename B::ConstVectorView mask = {});

}  // namespace vesta
