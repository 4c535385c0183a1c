// SPDX-License-Identifier: Apache-2.0
// Blurs fields with the separable Gaussian window, a few rows at a time. A field is an array with one value per pixel.
// The caller passes functions that compute the fields and process the blurred values, so every operator of the loss is
// two or three small lambdas. For image_kernels.simd.cpp.
//
// The fields are stored row by row, zero padded, in a ring buffer that fits into the cache. Four rows are blurred
// together along the columns, so that each load serves several sums. The sums are then transposed, so that the blur
// along the rows needs no shifts within vectors. The result is transposed back and passed to the caller, or to the ring
// buffer of a second blur. Each blurred value is one sum in the order of the taps, so the value does not depend on the
// range of rows. Rows outside the image are read from a row of zeros, so borders need no branch.
#pragma once

#include "kernels/image/block_access.h"
#include "kernels/image/gaussian_window.h"
#include "kernels/image/image_kernels.h"

// Inlines all functions called inside. Otherwise the compiler finds them too large, and keeps sums in memory instead of
// registers. Not used with sanitizers, because such functions then take minutes to compile.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define VESTA_FLATTEN
#else
#define VESTA_FLATTEN __attribute__((flatten))
#endif

namespace vesta {
inline namespace VESTA_ISA {

// Allocates rows of scratch memory.
template <class S>
class ScratchRows {
 public:
  explicit ScratchRows(const RowRange<S>& rows)
      : width_(rows.width), stride_(ScratchStride(rows.width)), next_(rows.scratch) {}

  // Allocates `count` rows, zeroes their padding, and returns the first value of the first row.
  S* Allocate(int count) {
    S* const first = next_ + kPad;
    for (int row = 0; row < count; ++row, next_ += stride_) {
      for (Index i = 0; i < kPad; ++i) next_[i] = S(0);
      for (Index i = kPad + width_; i < stride_; ++i) next_[i] = S(0);
    }
    return first;
  }

 private:
  static constexpr Index kPad = 16;
  int width_;
  Index stride_;
  S* next_;
};

// Position of pixel (row, column) of the range's plane in an image.
template <class S>
inline Index PositionOf(const RowRange<S>& rows, int row, int column) {
  return (Index{rows.plane} * rows.height + row) * rows.width + column;
}

// Blurs N fields that are computed from kStored stored fields, for instance u, e, u^2, e^2 from u and e.
template <int kStored, int N, class S>
class WindowBlur {
 public:
  using V = xsimd::batch<S>;
  // Rows computed together.
  static constexpr int kRows = kBlockRows<S>;

  WindowBlur(const RowRange<S>& rows, ScratchRows<S>& scratch)
      : width_(rows.width),
        height_(rows.height),
        stride_(ScratchStride(rows.width)),
        ring_(scratch.Allocate(kRing * kStored)),
        down_(scratch.Allocate(kRows * N)),
        zeros_(scratch.Allocate(1)) {
    for (int i = 0; i < width_; ++i) zeros_[i] = S(0);
    for (int k = 0; k <= kWindowRadius; ++k) tap_[k] = V(rows.taps[kWindowRadius + k]);
  }

  // Address of row `row` of stored field n. Rows are written in whole vectors, with zeros beyond the image width. The
  // ring buffer holds the last 24 rows: a block needs 14, and a blur that writes to this ring runs up to 3 rows ahead.
  S* Row(int row, int n) { return ring_ + Index{row % kRing * kStored + n} * stride_; }
  // Writes stored field n of a block.
  template <class Access>
  void StoreRows(int row, int n, int column, const Access& access, const typename Access::T& value) {
    const auto used = access.ZeroOutside(value);
    for (int r = 0; r < access.rows(); ++r) used.v[r].store_aligned(Row(row + r, n) + column);
  }

  // The output rows row .. end - 1 need the input rows InputBegin(row) .. InputEnd(end) - 1.
  static int InputBegin(int row) { return row > kWindowRadius ? row - kWindowRadius : 0; }
  int InputEnd(int end) const { return end + kWindowRadius < height_ ? end + kWindowRadius : height_; }

  // Computes output rows row..row + count - 1, count <= kRows, from the stored rows row - 5..row + count + 4.
  // derive(stored) returns the N fields. out(row, column, access, blurred) receives the result, block by block from
  // left to right. end_rows(row, count) is called after the last block.
  template <class Derive, class Out, class EndRows>
  void Block(int row, int count, const Derive& derive, const Out& out, const EndRows& end_rows) {
    const S* source[kInputRows][kStored];
    for (int k = 0; k < kInputRows; ++k) {
      const int from = row + k - kWindowRadius;
      for (int n = 0; n < kStored; ++n)
        source[k][n] = from >= 0 && from < InputEnd(row + count) ? Row(from, n) : zeros_;
    }
    Down(source, derive);
    Along(row, count, out);
    end_rows(row, count);
  }

 private:
  static constexpr int kRing = 24;
  static constexpr int kLanes = static_cast<int>(V::size);
  static constexpr int kInputRows = kRows + 2 * kWindowRadius;
  // Number of fields summed together: as many as registers allow.
  static constexpr int kTogether = sizeof(V) == 64 && N <= 4 ? N : N < 2 ? N : 2;
  using Rows = Several<V, kRows>;

  // First step, along the columns. The transposed sums are stored in kRows arrays (streams): element kRows g + r of
  // stream j belongs to row r and column kRows g + j. The neighbours of a vector of columns are then in another stream,
  // or at an offset that is a multiple of kRows.
  template <class Derive>
  VESTA_FLATTEN void Down(const S* const (&source)[kInputRows][kStored], const Derive& derive) {
    Unrolled<(N + kTogether - 1) / kTogether>([&](auto part) {
      constexpr int kFirst = part * kTogether, kCount = N - kFirst < kTogether ? N - kFirst : kTogether;
      for (int column = 0; column < width_; column += kLanes) {
        Rows sum[kCount];
        Unrolled<kInputRows>([&](auto k) {
          Fields<kStored, V> stored;
          Unrolled<kStored>([&](auto n) { stored.f[n] = V::load_aligned(source[k][n] + column); });
          const Fields<N, V> value = derive(stored);
          Unrolled<kRows>(
              [&](auto r) { Unrolled<kCount>([&](auto n) { Add<k - r>(sum[n].v[r], value.f[kFirst + n]); }); });
        });
        Unrolled<kCount>([&](auto n) {
          const Rows columns = Transposed(sum[n]);
          Unrolled<kRows>([&](auto j) { columns.v[j].store_aligned(Stream(kFirst + n, j) + column); });
        });
      }
    });
  }

  // Second step, along the rows.
  template <class Out>
  VESTA_FLATTEN void Along(int row, int count, const Out& out) {
    const auto blurred_at = [&](int column) {
      Fields<N, Rows> sum;
      Unrolled<N>([&](auto n) {
        Unrolled<kInputRows>([&](auto m) {
          // Columns m - 5, m - 5 + kRows, ... from `column`.
          constexpr int kStream = (m - kWindowRadius + 8 * kRows) % kRows;
          const V value = V::load_unaligned(Stream(n, kStream) + column + (m - kWindowRadius - kStream));
          Unrolled<kRows>([&](auto j) { Add<m - j>(sum.f[n].v[j], value); });
        });
        sum.f[n] = Transposed(sum.f[n]);
      });
      return sum;
    };
    ForBlocks<S, kRows>(width_, count,
                        [&](int column, const auto& access) { out(row, column, access, blurred_at(column)); });
  }

  S* Stream(int n, int j) const { return down_ + Index{n * kRows + j} * stride_; }

  // sum += tap k * value; for k = 0, sum = tap k * value. Does nothing if k is outside the window.
  template <int k>
  void Add(V& sum, const V& value) const {
    if constexpr (k >= 0 && k < kWindowTaps) {
      const V& tap = tap_[k < kWindowRadius ? kWindowRadius - k : k - kWindowRadius];
      if constexpr (k == 0) {
        sum = tap * value;
      } else {
        sum = Fma(tap, value, sum);
      }
    }
  }

  int width_, height_;
  Index stride_;
  S *ring_, *down_, *zeros_;
  V tap_[kWindowRadius + 1];
};

// Computes the stored fields of a blur from images, row by row. load(position, access) returns the kStored fields of
// the vector of pixels at index `position` of the images.
template <int kStored, int N, class S, class Load>
class ImageRows {
 public:
  ImageRows(const RowRange<S>& rows, WindowBlur<kStored, N, S>& blur, int begin, const Load& load)
      : rows_(rows), blur_(blur), next_(begin), load_(load) {}

  // Computes all rows before `end` and stores them in the blur's ring buffer.
  VESTA_FLATTEN void ComputeUpTo(int end) {
    for (; next_ < end; ++next_) {
      const Index position = PositionOf(rows_, next_, 0);
      ForBlocks<S, 1>(rows_.width, 1, [&](int column, const auto& access) {
        const auto fields = load_(position + column, access);
        Unrolled<kStored>([&](auto n) { blur_.StoreRows(next_, n, column, access, fields.f[n]); });
      });
    }
  }

 private:
  const RowRange<S>& rows_;
  WindowBlur<kStored, N, S>& blur_;
  int next_;
  const Load& load_;
};

// Computes the blurred rows begin .. end - 1, in order, as needed. source: the object that computes the input rows. It
// is an ImageRows, or a BlurredRows whose function `out` writes to the ring buffer of `blur`. derive, out, end_rows:
// see WindowBlur::Block. No block has rows both inside and outside the RowRange `rows`.
template <class Source, class Blur, class Derive, class Out, class EndRows>
class BlurredRows {
 public:
  template <class S>
  BlurredRows(const RowRange<S>& rows, Source& source, Blur& blur, int begin, int end, const Derive& derive,
              const Out& out, const EndRows& end_rows)
      : source_(source),
        blur_(blur),
        next_(begin),
        ends_{rows.begin, rows.end, end},
        derive_(derive),
        out_(out),
        end_rows_(end_rows) {}

  // Computes all rows before `end` once, and perhaps a few more.
  void ComputeUpTo(int end) {
    while (next_ < end) {
      int count = Blur::kRows;
      for (const int stop : ends_) {
        if (next_ < stop && stop - next_ < count) count = stop - next_;
      }
      source_.ComputeUpTo(blur_.InputEnd(next_ + count));
      blur_.Block(next_, count, derive_, out_, end_rows_);
      next_ += count;
    }
  }

 private:
  Source& source_;
  Blur& blur_;
  int next_;
  int ends_[3];
  const Derive& derive_;
  const Out& out_;
  const EndRows& end_rows_;
};

}  // namespace VESTA_ISA
}  // namespace vesta
