// SPDX-License-Identifier: Apache-2.0
// The curvature of a view's cost by its own unknowns, in the memory of B.
#pragma once

#include <array>
#include <vector>

#include "kernels/core/hd.h"
#include "kernels/core/span.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// By pixel of a channel: sum += scale (factors[0] column 0 + ...), added up in double.
template <class S, class U>
struct AddColumns {
  static constexpr int kMost = 12;  // columns

  double scale;
  int columns;
  Index stride;  // from a column to the next, values
  const S* first;
  U* sum;
  double factors[kMost];

  VESTA_HD void operator()(Index i) const {
    double product = 0;
    for (int k = 0; k < columns; ++k) product += factors[k] * static_cast<double>(first[k * stride + i]);
    sum[i] += static_cast<U>(scale * product);
  }
};

// The curvature of a view's cost by its own unknowns, in the memory of B.
// H = J^T W J of the view as it stands, without an exposure, by the default weights: square, free.num_tangent() numbers
// a side. Body in view_columns.inl.
template <class B>
std::vector<double> ViewCurvature(const FreeUnknowns& free, const std::array<double, 3>& background,
                                  const splat::Model<float>& model, const TargetView<B>& target);

}  // namespace vesta::gs
