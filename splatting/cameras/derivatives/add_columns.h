// A sum of columns of a view's Jacobian, for every memory space.
#pragma once

#include "kernels/core/hd.h"
#include "kernels/core/span.h"

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

}  // namespace vesta::gs
