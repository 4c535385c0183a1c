// SPDX-License-Identifier: Apache-2.0
// Columns of J that are zero, or contain only rounding errors. An example is the derivative of the perimeter of a
// regular polygon with respect to a tangential motion of a vertex. See docs/numerics.md, section "Columns of rounding
// errors".
#pragma once

#include <span>

#include "kernels/core/vector_backend.h"
#include "solver/internal/normal_equations/problem_adaptor.h"

namespace vesta {

// Returns the diagonal of H with raised entries, for ColumnScaling::kInverseRoot. Otherwise this scaling would turn a
// column of rounding errors into a column of length 1. The entry of such a column becomes the squared size of the rows
// in which the column has entries. This is about the entry of a column that determines these rows. The entry of a zero
// column becomes the median of the positive entries, because its own size is unknown. Returns an empty vector if there
// are no such columns, or only such columns. H is the sum over the batches. diag_h: its diagonal, num_tangent()
// entries, all finite.
//
// A column is taken for rounding errors if both conditions hold:
//   - its norm is at most 16 eps of the largest norm of a column, where eps is the epsilon of double
//   - its entries are at most about sqrt(eps) of the largest entry in their rows
// The second condition excludes parameters in large units, which may have small columns. The comparison of rows needs
// one product with J and one with J^T. It is skipped if no column fulfils the first condition.
template <Backend B>
typename B::Vector RaiseRoundingColumns(B& backend, std::span<LinearizationAdaptor<B>* const> batches,
                                        typename B::ConstVectorView diag_h);

}  // namespace vesta
