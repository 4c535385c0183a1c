// SPDX-License-Identifier: Apache-2.0
// Small symmetric matrices as packed lower triangles, one matrix in each SIMD lane. The host processes sixteen matrices
// together in vector registers; a GPU thread processes one.
#pragma once

#include <cmath>
#include <limits>

#include "kernels/core/block_diagonal.h"
#include "kernels/math/scalar.h"

namespace vesta {

// One value of each of kLanes matrices.
template <class S, int kLanes>
struct alignas(kLanes == 1 ? alignof(S) : 64) BlockLanes {
  S lane[kLanes];
};

namespace block_internal {

// Smallest pivot of a block scaled to a unit diagonal. Smaller pivots are raised to it.
template <class S>
inline constexpr S kSmallestPivot = sizeof(S) == sizeof(float) ? S(1e-6) : S(1e-13);
}  // namespace block_internal

// Cholesky factorisation of kLanes blocks of order `size`, in place. a: the packed lower triangles (packed.h), replaced
// by L with 1 / L_kk on the diagonal. If a diagonal entry of a block is not positive and finite, its row and column are
// treated as 0. Pivots below kSmallestPivot are raised to it. Adds the number of these entries and pivots to
// `num_replaced`, per lane. root, scale and left are scratch arrays of `size` elements.
//
// The blocks are first scaled to a unit diagonal. The squared entries of row i of L sum to diagonal entry i. The square
// of an entry is therefore at most diagonal entry i minus the squares of the entries before it in row i. Clamping to
// this bound keeps all numbers finite for any input.
template <int kLanes, class S>
VESTA_HD inline void FactorizeLanes(int size, BlockLanes<S, kLanes>* a, BlockLanes<S, kLanes>* root,
                                    BlockLanes<S, kLanes>* scale, BlockLanes<S, kLanes>* left,
                                    BlockLanes<int, kLanes>& num_replaced) {
  using std::sqrt;
  const S smallest_pivot = block_internal::kSmallestPivot<S>;
  for (int i = 0; i < size; ++i) {
    const BlockLanes<S, kLanes> d = a[PackedLower(i, i)];
    for (int l = 0; l < kLanes; ++l) {
      const bool usable = d.lane[l] > S(0) && d.lane[l] <= std::numeric_limits<S>::max();
      const S r = sqrt(usable ? d.lane[l] : S(1)), inverse = S(1) / r;
      root[i].lane[l] = usable ? r : S(0);
      scale[i].lane[l] = usable ? inverse : S(0);
      left[i].lane[l] = S(1);
      num_replaced.lane[l] += usable ? 0 : 1;
    }
  }
  for (int i = 0; i < size; ++i) {
    const BlockLanes<S, kLanes> row = scale[i];
    for (int j = 0; j < i; ++j) {
      const BlockLanes<S, kLanes> bound = root[j], column = scale[j];
      BlockLanes<S, kLanes>& entry = a[PackedLower(i, j)];
      for (int l = 0; l < kLanes; ++l) {
        // The first product may overflow, so it is clamped. The magnitude of the second one is then at most about 1.
        const S half = entry.lane[l] * row.lane[l];
        entry.lane[l] = Min(Max(half, -bound.lane[l]), bound.lane[l]) * column.lane[l];
      }
    }
  }
  for (int j = 0; j < size; ++j) {
    BlockLanes<S, kLanes> inverse;
    for (int l = 0; l < kLanes; ++l) {
      const S pivot = Max(left[j].lane[l], smallest_pivot);
      num_replaced.lane[l] += ((pivot > left[j].lane[l]) & (root[j].lane[l] > S(0))) ? 1 : 0;
      inverse.lane[l] = S(1) / sqrt(pivot);
    }
    for (int i = j + 1; i < size; ++i) {
      BlockLanes<S, kLanes> sum = a[PackedLower(i, j)], rest = left[i];
      for (int k = 0; k < j; ++k) {
        const BlockLanes<S, kLanes>&x = a[PackedLower(i, k)], &y = a[PackedLower(j, k)];
        for (int l = 0; l < kLanes; ++l) sum.lane[l] -= x.lane[l] * y.lane[l];
      }
      for (int l = 0; l < kLanes; ++l) {
        const S bound = sqrt(rest.lane[l]);
        sum.lane[l] = Min(Max(sum.lane[l] * inverse.lane[l], -bound), bound);
        rest.lane[l] = Max(rest.lane[l] - sum.lane[l] * sum.lane[l], S(0));
      }
      a[PackedLower(i, j)] = sum;
      left[i] = rest;
    }
    a[PackedLower(j, j)] = inverse;
  }
  // Undo the scaling. The diagonal holds reciprocals, or 0 for rows and columns treated as 0.
  for (int i = 0; i < size; ++i) {
    const BlockLanes<S, kLanes> row = root[i], inverse = scale[i];
    for (int j = 0; j <= i; ++j) {
      BlockLanes<S, kLanes>& entry = a[PackedLower(i, j)];
      const BlockLanes<S, kLanes>& factor = j < i ? row : inverse;
      for (int l = 0; l < kLanes; ++l) entry.lane[l] *= factor.lane[l];
    }
  }
}

// x = L^-T L^-1 x for kLanes blocks, with L from FactorizeLanes.
template <int kLanes, class S>
VESTA_HD inline void SolveLanes(int size, const BlockLanes<S, kLanes>* a, BlockLanes<S, kLanes>* x) {
  for (int i = 0; i < size; ++i) {
    BlockLanes<S, kLanes> sum = x[i];
    for (int k = 0; k < i; ++k) {
      for (int l = 0; l < kLanes; ++l) sum.lane[l] -= a[PackedLower(i, k)].lane[l] * x[k].lane[l];
    }
    for (int l = 0; l < kLanes; ++l) x[i].lane[l] = sum.lane[l] * a[PackedLower(i, i)].lane[l];
  }
  for (int i = size - 1; i >= 0; --i) {
    BlockLanes<S, kLanes> sum = x[i];
    for (int k = i + 1; k < size; ++k) {
      for (int l = 0; l < kLanes; ++l) sum.lane[l] -= a[PackedLower(k, i)].lane[l] * x[k].lane[l];
    }
    for (int l = 0; l < kLanes; ++l) x[i].lane[l] = sum.lane[l] * a[PackedLower(i, i)].lane[l];
  }
}

// y = A x for kLanes blocks.
template <int kLanes, class S>
VESTA_HD inline void MultiplyLanes(int size, const BlockLanes<S, kLanes>* a, const BlockLanes<S, kLanes>* x,
                                   BlockLanes<S, kLanes>* y) {
  for (int i = 0; i < size; ++i) {
    BlockLanes<S, kLanes> sum{};
    for (int k = 0; k < size; ++k) {
      const BlockLanes<S, kLanes>& entry = a[i >= k ? PackedLower(i, k) : PackedLower(k, i)];
      for (int l = 0; l < kLanes; ++l) sum.lane[l] += entry.lane[l] * x[k].lane[l];
    }
    y[i] = sum;
  }
}

}  // namespace vesta
