// The separable Gaussian window, one or two image rows at a time, as a skeleton: a caller says which fields are blurred
// and what becomes of the result, so every operator of the loss is two small lambdas. Included by
// image_kernels.simd.cpp.
#pragma once

#include <type_traits>

#include "kernels/image/gaussian_window.h"
#include "kernels/image/image_kernels.h"
#include "kernels/math/lanes.h"

namespace vesta {
inline namespace VESTA_ISA {

using DoubleLanes = xsimd::batch<double>;

template <>
struct Elementary<DoubleLanes> {
  using Mask = DoubleLanes::batch_bool_type;
  static DoubleLanes Select(const Mask& m, const DoubleLanes& a, const DoubleLanes& b) {
    return xsimd::select(m, a, b);
  }
  static DoubleLanes Fma(const DoubleLanes& a, const DoubleLanes& b, const DoubleLanes& c) {
    return xsimd::fma(a, b, c);
  }
  static DoubleLanes Max(const DoubleLanes& a, const DoubleLanes& b) { return xsimd::max(a, b); }
  static DoubleLanes Min(const DoubleLanes& a, const DoubleLanes& b) { return xsimd::min(a, b); }
};

// Memory access of a full vector of pixels.
template <class S>
struct WholeVector {
  using V = xsimd::batch<S>;
  static constexpr int kWidth = static_cast<int>(V::size);
  V Load(const S* p) const { return V::load_unaligned(p); }
  void Store(S* p, const V& v) const { v.store_unaligned(p); }
  V Used(const V& v) const { return v; }
};

// Memory access of the `count` pixels at a row's end; other lanes are zero when loaded and never stored.
template <class S>
struct PartialVector {
  using V = xsimd::batch<S>;
  static constexpr int kWidth = static_cast<int>(V::size);
  int count;

  V Load(const S* p) const {
    alignas(64) S lane[kWidth] = {};
    for (int i = 0; i < count; ++i) lane[i] = p[i];
    return V::load_aligned(lane);
  }
  void Store(S* p, const V& v) const {
    alignas(64) S lane[kWidth];
    v.store_aligned(lane);
    for (int i = 0; i < count; ++i) p[i] = lane[i];
  }
  // v with the other lanes zeroed.
  V Used(const V& v) const {
    alignas(64) S lane[kWidth];
    v.store_aligned(lane);
    return Load(lane);
  }
};

// Calls f(column, access, block) over a row: blocks of kBlock vectors, then single ones, then the rest.
template <int kBlock, class S, class F>
inline void ForColumns(int width, const F& f) {
  constexpr int kWidth = WholeVector<S>::kWidth;
  int column = 0;
  for (; column + kBlock * kWidth <= width; column += kBlock * kWidth) {
    f(column, WholeVector<S>{}, std::integral_constant<int, kBlock>{});
  }
  for (; column + kWidth <= width; column += kWidth) f(column, WholeVector<S>{}, std::integral_constant<int, 1>{});
  if (column < width) f(column, PartialVector<S>{width - column}, std::integral_constant<int, 1>{});
}

// The values of N fields at one vector of pixels.
template <int N, class V>
struct Fields {
  V f[N];
};

// First half of the blur, down the columns: rows row..row + kRows - 1, of N fields; field n of
// row r goes to scratch row r * N + n. Two rows at once need twelve rows of input instead of twenty-two.
template <int kRows, int N, class S, class Field>
inline void BlurColumns(const RowRange<S>& rows, int row, const Field& field) {
  using V = xsimd::batch<S>;
  constexpr int kWidth = WholeVector<S>::kWidth;
  // Enough independent sums to hide the latency of a fused multiply-add, few enough to stay in registers.
  constexpr int kBlock = N >= 3 ? 1 : 4;
  const int first = row < kWindowRadius ? -row : -kWindowRadius;
  const int below = rows.height - 1 - row;
  const int reach = kWindowRadius + kRows - 1;
  const int last = below < reach ? below : reach;

  ForColumns<kBlock, S>(rows.width, [&](int column, auto access, auto block) {
    V sum[kRows][N][block];
    for (auto& row_sum : sum) {
      for (auto& field_sum : row_sum) {
        for (V& v : field_sum) v = V(S(0));
      }
    }
    for (int k = first; k <= last; ++k) {
      const Index position = static_cast<Index>(row + k) * rows.width + column;
      for (int b = 0; b < block; ++b) {
        const Fields<N, V> value = field(position + b * kWidth, access);
        for (int r = 0; r < kRows; ++r) {
          const V tap(rows.taps[k - r + kWindowRadius]);
          for (int n = 0; n < N; ++n) sum[r][n][b] = Fma(tap, value.f[n], sum[r][n][b]);
        }
      }
    }
    for (int r = 0; r < kRows; ++r) {
      for (int n = 0; n < N; ++n) {
        S* target = rows.scratch + (r * N + n) * rows.scratch_stride + column;
        for (int b = 0; b < block; ++b) access.Store(target + b * kWidth, sum[r][n][b]);
      }
    }
  });
}

// Second half, along row `row`, from N scratch rows that begin at `scratch`.
template <int N, class S, class Out>
inline void BlurAlong(const RowRange<S>& rows, int row, const S* scratch, const Out& out) {
  using V = xsimd::batch<S>;
  constexpr int kWidth = WholeVector<S>::kWidth;
  constexpr int kBlock = N >= 3 ? 2 : 8;
  ForColumns<kBlock, S>(rows.width, [&](int column, auto access, auto block) {
    Fields<N, V> sum[block];
    for (auto& block_sum : sum) {
      for (V& v : block_sum.f) v = V(S(0));
    }
    for (int k = 0; k < kWindowTaps; ++k) {
      const V tap(rows.taps[k]);
      const S* source = scratch + column + (k - kWindowRadius);
      for (int n = 0; n < N; ++n) {
        for (int b = 0; b < block; ++b) {
          sum[b].f[n] = Fma(tap, V::load_unaligned(source + n * rows.scratch_stride + b * kWidth), sum[b].f[n]);
        }
      }
    }
    for (int b = 0; b < block; ++b) out(static_cast<Index>(row) * rows.width + column + b * kWidth, access, sum[b]);
  });
}

// Blurs N fields over the range of rows. field(position, access) gives the unblurred fields at the vector of pixels
// that starts at `position` of the plane; out(position, access, fields) takes the blurred ones, along a row from
// left to right; end_row(row) follows each row.
template <int N, class S, class Field, class Out, class EndRow>
inline void BlurRows(const RowRange<S>& rows, const Field& field, const Out& out, const EndRow& end_row) {
  static_assert(2 * N <= RowRange<S>::kScratchRows);
  for (int row = rows.begin; row < rows.end;) {
    const bool pair = row + 1 < rows.end;
    if (pair) {
      BlurColumns<2, N>(rows, row, field);
    } else {
      BlurColumns<1, N>(rows, row, field);
    }
    const int count = pair ? 2 : 1;
    for (int r = 0; r < count; ++r, ++row) {
      BlurAlong<N>(rows, row, rows.scratch + r * N * rows.scratch_stride, out);
      end_row(row);
    }
  }
}

template <int N, class S, class Field, class Out>
inline void BlurRows(const RowRange<S>& rows, const Field& field, const Out& out) {
  BlurRows<N>(rows, field, out, [](int) {});
}

}  // namespace VESTA_ISA
}  // namespace vesta
