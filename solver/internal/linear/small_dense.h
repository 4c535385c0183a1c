// SPDX-License-Identifier: Apache-2.0
// Products with small dense matrices, such as blocks of block-sparse Jacobians, with loops unrolled for common sizes.
// Entry (row, col), col <= row, of a packed lower triangle is at PackedLower(row, col) (kernels/core/packed.h).
#pragma once

#include <type_traits>

#include "kernels/core/block_diagonal.h"

namespace vesta::small_dense {

// Calls body(n) with n = size. For common sizes, n is a compile-time constant.
template <class Body>
inline void WithSize(int size, const Body& body) {
  switch (size) {
    case 1:
      return body(std::integral_constant<int, 1>{});
    case 2:
      return body(std::integral_constant<int, 2>{});
    case 3:
      return body(std::integral_constant<int, 3>{});
    case 4:
      return body(std::integral_constant<int, 4>{});
    case 6:
      return body(std::integral_constant<int, 6>{});
    case 7:
      return body(std::integral_constant<int, 7>{});
    case 9:
      return body(std::integral_constant<int, 9>{});
    default:
      return body(size);
  }
}

// out += A x. A is rows x cols; row i begins at a + i * stride. Likewise below.
inline void AddProduct(const double* a, int stride, int rows, int cols, const double* x, double* out) {
  WithSize(cols, [&](auto n) {
    for (int i = 0; i < rows; ++i) {
      // Two independent sums for one vector register.
      double even = 0, odd = 0;
      const double* row = a + i * stride;
      for (int c = 0; c + 1 < n; c += 2) {
        even += row[c] * x[c];
        odd += row[c + 1] * x[c + 1];
      }
      if (n % 2 == 1) even += row[n - 1] * x[n - 1];
      out[i] += even + odd;
    }
  });
}

// out += A^T u.
inline void AddTransposeProduct(const double* a, int stride, int rows, int cols, const double* u, double* out) {
  WithSize(cols, [&](auto n) {
    for (int i = 0; i < rows; ++i) {
      for (int c = 0; c < n; ++c) out[c] += a[i * stride + c] * u[i];
    }
  });
}

// packed += A^T A, as a packed lower triangle.
inline void AddGram(const double* a, int stride, int rows, int cols, double* packed) {
  WithSize(cols, [&](auto n) {
    for (int i = 0; i < rows; ++i) {
      const double* row = a + i * stride;
      for (int r = 0; r < n; ++r) {
        for (int c = 0; c <= r; ++c) packed[PackedLower(r, c)] += row[r] * row[c];
      }
    }
  });
}

// x = L^-1 x and x = L^-T x. l: packed lower triangle of L with 1 / L_kk on the diagonal, as from
// BlockDiagonal::Factorize.
inline void SolveLower(const double* l, int size, double* x) {
  WithSize(size, [&](auto n) {
    for (int r = 0; r < n; ++r) {
      for (int c = 0; c < r; ++c) x[r] -= l[PackedLower(r, c)] * x[c];
      x[r] *= l[PackedLower(r, r)];
    }
  });
}
inline void SolveLowerTranspose(const double* l, int size, double* x) {
  WithSize(size, [&](auto n) {
    for (int r = n - 1; r >= 0; --r) {
      for (int c = r + 1; c < n; ++c) x[r] -= l[PackedLower(c, r)] * x[c];
      x[r] *= l[PackedLower(r, r)];
    }
  });
}

// X = L^-1 X for a row-major matrix X with `size` rows.
inline void SolveLowerMatrix(const double* l, int size, int cols, double* x) {
  WithSize(cols, [&](auto n) {
    for (int r = 0; r < size; ++r) {
      for (int c = 0; c < r; ++c) {
        for (int k = 0; k < n; ++k) x[r * n + k] -= l[PackedLower(r, c)] * x[c * n + k];
      }
      for (int k = 0; k < n; ++k) x[r * n + k] *= l[PackedLower(r, r)];
    }
  });
}

}  // namespace vesta::small_dense
