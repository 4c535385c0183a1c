// SPDX-License-Identifier: Apache-2.0
// Householder reflections of matrices with few columns, without extra memory. For these matrices, Eigen's general
// routines take several times as long.
#pragma once

#include <cmath>
#include <cstddef>

namespace vesta::householder {

inline double Dot(const double* x, const double* y, int n) {
  // Independent sums, because the additions of a single one would wait for each other.
  double sums[4] = {};
  int i = 0;
  for (; i + 4 <= n; i += 4) {
    for (int lane = 0; lane < 4; ++lane) sums[lane] += x[i + lane] * y[i + lane];
  }
  for (; i < n; ++i) sums[0] += x[i] * y[i];
  return (sums[0] + sums[2]) + (sums[1] + sums[3]);
}

// Reflects the rows k to rows - 1 of A and b so that column k of A becomes zero below row k (Golub and Van Loan, Matrix
// Computations, section 5.1). a: rows x cols, column-major; the columns before k are not read. The entries of column k
// below row k are not set to zero; they store part of the reflection. The squares of the entries of A must neither
// overflow nor underflow.
inline void Reflect(double* a, int rows, int cols, int k, double* b) {
  const int below = rows - k - 1;
  double* const column = a + static_cast<std::ptrdiff_t>(k) * rows + k;
  const double* const tail = column + 1;
  const double square = Dot(tail, tail, below), head = *column;
  if (square == 0) return;
  // The reflection is I - v v^T / scale with v = (first, tail).
  const double norm = std::sqrt(head * head + square);
  const double first = head + std::copysign(norm, head), inverse_scale = 1 / (norm * std::abs(first));
  const auto reflect = [&](double* y) {
    const double factor = inverse_scale * (first * *y + Dot(tail, y + 1, below));
    *y -= factor * first;
    for (int i = 0; i < below; ++i) y[i + 1] -= factor * tail[i];
  };
  for (int c = 1; c < cols - k; ++c) reflect(column + static_cast<std::ptrdiff_t>(c) * rows);
  reflect(b + k);
  *column = -std::copysign(norm, head);
}

}  // namespace vesta::householder
