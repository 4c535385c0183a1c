// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/sparse_cholesky/front_kernels.h"

#include <cmath>
#include <xsimd/xsimd.hpp>

#include "kernels/math/lanes.h"

namespace vesta {
inline namespace VESTA_ISA {
namespace {

using V = xsimd::batch<double>;
constexpr Index kLanes = static_cast<Index>(V::size);

// Returns c - a b.
inline V SubtractProduct(const V& a, const V& b, const V& c) {
#if defined(__AVX512F__)
  // xsimd 8.1 uses two instructions at this width.
  return _mm512_fnmadd_pd(a, b, c);
#elif defined(__FMA__)
  return xsimd::fnma(a, b, c);
#else
  return c - a * b;
#endif
}

// Whether an update begins with the values in memory, or with zeros.
enum class From { kMemory, kZero };

// c(r, col) -= sum_k a(r, k) b(col, k) for kBatches batches of rows and kColumns columns. All are column-major; a and b
// have the same stride.
template <int kColumns, int kBatches, From kFrom>
inline void UpdateTile(const double* a, const double* b, Index stride, Index count, double* c, Index c_stride) {
  V sum[kColumns][kBatches];
  for (int col = 0; col < kColumns; ++col) {
    for (int i = 0; i < kBatches; ++i) {
      sum[col][i] = kFrom == From::kZero ? V(0.0) : V::load_unaligned(c + col * c_stride + i * kLanes);
    }
  }
  for (Index k = 0; k < count; ++k) {
    V x[kBatches];
    for (int i = 0; i < kBatches; ++i) x[i] = V::load_unaligned(a + k * stride + i * kLanes);
    for (int col = 0; col < kColumns; ++col) {
      const V factor(b[k * stride + col]);
      for (int i = 0; i < kBatches; ++i) sum[col][i] = SubtractProduct(x[i], factor, sum[col][i]);
    }
  }
  for (int col = 0; col < kColumns; ++col) {
    for (int i = 0; i < kBatches; ++i) sum[col][i].store_unaligned(c + col * c_stride + i * kLanes);
  }
}

// The same for `rows` rows, rounded up to whole batches.
template <int kColumns, From kFrom>
void UpdateStrip(const double* a, const double* b, Index stride, Index count, double* c, Index c_stride, Index rows) {
  // As many accumulators as fit in sixteen registers with the operands.
  constexpr int kBatches = kColumns == 1 ? 4 : 12 / kColumns;
  Index r = 0;
  for (; r + (kBatches - 1) * kLanes < rows; r += kBatches * kLanes) {
    UpdateTile<kColumns, kBatches, kFrom>(a + r, b, stride, count, c + r, c_stride);
  }
  for (; r < rows; r += kLanes) UpdateTile<kColumns, 1, kFrom>(a + r, b, stride, count, c + r, c_stride);
}

// Columns first..first + kColumns of the panel: subtracts the contribution of the columns before them, then factorises.
template <int kColumns>
Index FactorizeStrip(const FrontPanel& panel, Index first, const double* least) {
  // Batches begin at multiples of their width, so they include rows above the diagonal, whose results are not used.
  const Index begin = first / kLanes * kLanes;
  double* const columns = panel.values + first * panel.stride;
  UpdateStrip<kColumns, From::kMemory>(panel.values + begin, panel.values + first, panel.stride, first, columns + begin,
                                       panel.stride, panel.rows - begin);
  Index raised = 0;
  for (int c = 0; c < kColumns; ++c) {
    double* const column = columns + c * panel.stride;
    double pivot = column[first + c];
    if (!(pivot > least[first + c])) {
      pivot = least[first + c] > 0 ? least[first + c] : 1;
      ++raised;
    }
    const double root = std::sqrt(pivot);
    const V inverse(1 / root);
    for (Index r = begin; r < panel.rows; r += kLanes) {
      (V::load_unaligned(column + r) * inverse).store_unaligned(column + r);
    }
    column[first + c] = root;
    for (int later = c + 1; later < kColumns; ++later) {
      double* const target = columns + later * panel.stride;
      const V factor(column[first + later]);
      for (Index r = begin; r < panel.rows; r += kLanes) {
        SubtractProduct(V::load_unaligned(column + r), factor, V::load_unaligned(target + r))
            .store_unaligned(target + r);
      }
    }
  }
  return raised;
}

Index Factorize(const FrontPanel& panel, const double* least) {
  Index raised = 0, first = 0;
  for (; first + 6 <= panel.pivots; first += 6) raised += FactorizeStrip<6>(panel, first, least);
  for (; first + 3 <= panel.pivots; first += 3) raised += FactorizeStrip<3>(panel, first, least);
  for (; first < panel.pivots; ++first) raised += FactorizeStrip<1>(panel, first, least);
  return raised;
}

template <From kFrom>
void SubtractOuter(const FrontPanel& panel, double* update, Index update_stride, Index begin, Index end) {
  const double* below = panel.values + panel.pivots;
  const Index rows = panel.rows - panel.pivots;
  Index first = begin;
  const auto strip = [&](auto update_strip) {
    const Index top = first / kLanes * kLanes;
    update_strip(below + top, below + first, panel.stride, panel.pivots, update + first * update_stride + top,
                 update_stride, rows - top);
  };
  for (; first + 6 <= end; first += 6) strip(UpdateStrip<6, kFrom>);
  for (; first + 3 <= end; first += 3) strip(UpdateStrip<3, kFrom>);
  for (; first < end; ++first) strip(UpdateStrip<1, kFrom>);
}

// Columns first..first + kColumns of a front's part of solving L y = x.
template <int kColumns>
void ForwardStrip(const FrontPanel& panel, Index first, double* x) {
  const double* column[kColumns];
  for (int c = 0; c < kColumns; ++c) {
    column[c] = panel.values + (first + c) * panel.stride;
    double value = x[first + c];
    for (int k = 0; k < c; ++k) value -= column[k][first + c] * x[first + k];
    x[first + c] = value / column[c][first + c];
  }
  Index r = first + kColumns;
  for (; r + kLanes <= panel.rows; r += kLanes) {
    V sum = V::load_unaligned(x + r);
    for (int c = 0; c < kColumns; ++c) sum = SubtractProduct(V::load_unaligned(column[c] + r), V(x[first + c]), sum);
    sum.store_unaligned(x + r);
  }
  for (; r < panel.rows; ++r) {
    for (int c = 0; c < kColumns; ++c) x[r] -= column[c][r] * x[first + c];
  }
}

// The same for L^T y = x.
template <int kColumns>
void BackwardStrip(const FrontPanel& panel, Index first, double* x) {
  V sum[kColumns];
  const double* column[kColumns];
  for (int c = 0; c < kColumns; ++c) {
    column[c] = panel.values + (first + c) * panel.stride;
    sum[c] = V(0.0);
  }
  Index r = first + kColumns;
  for (; r + kLanes <= panel.rows; r += kLanes) {
    const V below = V::load_unaligned(x + r);
    for (int c = 0; c < kColumns; ++c) sum[c] = SubtractProduct(V::load_unaligned(column[c] + r), below, sum[c]);
  }
  for (int c = kColumns - 1; c >= 0; --c) {
    double value = x[first + c] + LaneSum(sum[c]);
    for (Index i = r; i < panel.rows; ++i) value -= column[c][i] * x[i];
    for (int k = c + 1; k < kColumns; ++k) value -= column[c][first + k] * x[first + k];
    x[first + c] = value / column[c][first + c];
  }
}

void Forward(const FrontPanel& panel, double* x) {
  Index first = 0;
  for (; first + 3 <= panel.pivots; first += 3) ForwardStrip<3>(panel, first, x);
  for (; first < panel.pivots; ++first) ForwardStrip<1>(panel, first, x);
}

void Backward(const FrontPanel& panel, double* x) {
  Index end = panel.pivots;
  for (; end % 3 != 0; --end) BackwardStrip<1>(panel, end - 1, x);
  for (; end > 0; end -= 3) BackwardStrip<3>(panel, end - 3, x);
}

}  // namespace

const FrontKernels& CompiledFrontKernels() {
  static constexpr FrontKernels kKernels = {Factorize, SubtractOuter<From::kMemory>, SubtractOuter<From::kZero>,
                                            Forward, Backward};
  return kKernels;
}

}  // namespace VESTA_ISA
}  // namespace vesta
