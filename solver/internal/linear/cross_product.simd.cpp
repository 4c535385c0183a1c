// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/linear/cross_product.h"

#include <type_traits>

#include "kernels/math/isa.h"
#include "solver/internal/linear/small_dense.h"

namespace vesta {
inline namespace VESTA_ISA {
namespace {

// Calls body(sum), where sum points to the n numbers of `row` or, if n is a compile-time constant, to a copy of them
// that fits into registers and is written back.
template <class Size, class Body>
inline void ForRow(Size n, double* row, const Body& body) {
  if constexpr (std::is_same_v<Size, int>) {
    body(row);
  } else {
    double sum[Size::value];
    for (int c = 0; c < n; ++c) sum[c] = row[c];
    body(sum);
    for (int c = 0; c < n; ++c) row[c] = sum[c];
  }
}

}  // namespace

void CompiledAddCrossProduct(const StridedMatrix& a, const StridedMatrix& b, int rows, double sign, double* w) {
  small_dense::WithSize(b.cols, [&](auto n) {
    for (int r = 0; r < a.cols; ++r) {
      ForRow(n, w + r * n, [&](auto* sum) {
        for (int i = 0; i < rows; ++i) {
          const double factor = sign * a.values[i * a.stride + r];
          for (int c = 0; c < n; ++c) sum[c] += factor * b.values[i * b.stride + c];
        }
      });
    }
  });
}

}  // namespace VESTA_ISA
}  // namespace vesta
