// SPDX-License-Identifier: Apache-2.0
#include "bench/deconvolution/separable_correlation.h"

#include "kernels/math/lanes.h"

namespace vesta::deconvolution {
inline namespace VESTA_ISA {
namespace {

using V = xsimd::batch<double>;

constexpr Index kWidth = V::size;
static_assert(kSpill % kWidth == 0 && kWidth <= kCorrelationSlack);
// Rows processed together, which share each loaded row; columns processed together, whose intermediate values fit into
// the L1 cache.
constexpr int kRows = 4;
constexpr Index kTile = 256;
// Independent vectors in the first pass, to hide the latency.
constexpr int kBlock = 2;
constexpr Index kScratch = kTile + kSpill + kBlock * kCorrelationSlack;

// First pass, along the columns, for kCount rows and kVectors vectors of columns:
//   scratch(r, j) = sum_p column[p] in(row + r + p, column + j).
// `padded` is the code of the column with kRows - 1 zeros at either end.
template <int kCount, int kVectors>
void DownColumns(const CorrelationArgs& args, const double* padded, Index row, Index column, double* scratch) {
  V sum[kCount][kVectors];
  for (auto& row_sum : sum) {
    for (V& v : row_sum) v = V(0.0);
  }
  const double* in = args.in + row * args.in_stride + column;
  for (int k = 0; k < kTaps + kCount - 1; ++k, in += args.in_stride) {
    V value[kVectors];
    for (int b = 0; b < kVectors; ++b) value[b] = V::load_unaligned(in + b * kWidth);
    for (int r = 0; r < kCount; ++r) {
      const V tap(padded[k - r + kRows - 1]);
      for (int b = 0; b < kVectors; ++b) sum[r][b] = xsimd::fma(tap, value[b], sum[r][b]);
    }
  }
  for (int r = 0; r < kCount; ++r) {
    for (int b = 0; b < kVectors; ++b) sum[r][b].store_unaligned(scratch + r * kScratch + b * kWidth);
  }
}

void Store(const CorrelationArgs& args, Index position, Index count, const V& value) {
  double* out = args.out + position;
  if (count >= kWidth) {
    (args.accumulate ? V::load_unaligned(out) + value : value).store_unaligned(out);
    return;
  }
  double lane[kWidth];
  value.store_unaligned(lane);
  for (Index i = 0; i < count; ++i) out[i] = args.accumulate ? out[i] + lane[i] : lane[i];
}

// Both passes for kCount rows, starting at `row`.
template <int kCount>
void Rows(const CorrelationArgs& args, const double* padded, Index row) {
  double scratch[kCount * kScratch];
  for (Index first = 0; first < args.width; first += kTile) {
    const Index count = args.width - first < kTile ? args.width - first : kTile;
    Index j = 0;
    for (; j + (kBlock - 1) * kWidth < count + kSpill; j += kBlock * kWidth) {
      DownColumns<kCount, kBlock>(args, padded, row, first + j, scratch + j);
    }
    for (; j < count + kSpill; j += kWidth) DownColumns<kCount, 1>(args, padded, row, first + j, scratch + j);
    for (j = 0; j < count; j += kWidth) {
      V sum[kCount];
      for (V& v : sum) v = V(0.0);
      for (int q = 0; q < kTaps; ++q) {
        const V tap(args.row[q]);
        for (int r = 0; r < kCount; ++r) {
          sum[r] = xsimd::fma(tap, V::load_unaligned(scratch + r * kScratch + j + q), sum[r]);
        }
      }
      for (int r = 0; r < kCount; ++r) Store(args, (row + r) * args.width + first + j, count - j, sum[r]);
    }
  }
}

void Correlate(const CorrelationArgs& args, Index begin, Index end) {
  double padded[kTaps + 2 * (kRows - 1)] = {};
  for (int p = 0; p < kTaps; ++p) padded[p + kRows - 1] = args.column[p];
  Index row = begin;
  for (; row + kRows <= end; row += kRows) Rows<kRows>(args, padded, row);
  for (; row < end; ++row) Rows<1>(args, padded, row);
}

}  // namespace

CorrelateRows CompiledCorrelateRows() { return &Correlate; }

}  // namespace VESTA_ISA
}  // namespace vesta::deconvolution
