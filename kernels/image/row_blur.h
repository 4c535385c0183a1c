// The separable Gaussian window over a few rows at a time, as a skeleton: a caller says which fields are blurred and
// what becomes of the result, so every operator of the loss is two or three small lambdas. Included by
// image_kernels.simd.cpp.
//
// Rows stream through a ring that stays in cache: unblurred fields come in row by row, zero padded; a few rows are
// blurred down the columns together, so that one load serves several sums; then each is blurred along the row and
// handed on, possibly into the ring of a second blur. Each blurred value is one sum in the order of the taps, whichever
// rows are made together, so results do not depend on where a range of rows begins or ends. Rows outside the image are
// a row of zeros: there is no branch at borders.
#pragma once

#include "kernels/image/gaussian_window.h"
#include "kernels/image/image_kernels.h"
#include "kernels/image/lane_access.h"

// Inlines all that the function calls. The compiler's own measure of what is too large to inline would leave sums in
// memory.
#define VESTA_FLATTEN __attribute__((flatten))

namespace vesta {
inline namespace VESTA_ISA {

// Hands out the rows of a range's scratch memory.
template <class S>
class ScratchRows {
 public:
  explicit ScratchRows(const RowRange<S>& rows)
      : width_(rows.width), stride_(ScratchStride(rows.width)), next_(rows.scratch) {}

  // The next `count` rows: the address of the first row's first value. Zero around the `width` values of each row.
  S* Take(int count) {
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

// Where pixel (row, column) of the range's plane lies in an image.
template <class S>
inline Index PositionOf(const RowRange<S>& rows, int row, int column) {
  return (Index{rows.plane} * rows.height + row) * rows.width + column;
}

// Blurs N fields that are computed from kStored ones.
template <int kStored, int N, class S>
class WindowBlur {
 public:
  using V = xsimd::batch<S>;
  // Rows made together: as many sums as registers hold.
  static constexpr int kRows = N == 1 || (N <= 4 && sizeof(V) == 64) ? 4 : 2;

  WindowBlur(const RowRange<S>& rows, ScratchRows<S>& scratch)
      : width_(rows.width),
        height_(rows.height),
        stride_(ScratchStride(rows.width)),
        ring_(scratch.Take(kRing * kStored)),
        down_(scratch.Take(kRows * N)),
        zeros_(scratch.Take(1)) {
    for (int i = 0; i < width_; ++i) zeros_[i] = S(0);
    for (int k = 0; k <= kWindowRadius; ++k) tap_[k] = V(rows.taps[kWindowRadius + k]);
  }

  // Where row `row` of stored field n is to be written, in whole vectors, zero behind the width. The ring keeps the
  // last 24 rows: those that a block needs (14), and those that a blur before this one makes too early (3).
  S* Row(int row, int n) { return ring_ + Index{row % kRing * kStored + n} * stride_; }

  // The rows that a window reaches: from InputBegin(row) on, and before InputEnd(end) for all rows before `end`.
  static int InputBegin(int row) { return row > kWindowRadius ? row - kWindowRadius : 0; }
  int InputEnd(int end) const { return end + kWindowRadius < height_ ? end + kWindowRadius : height_; }

  // Makes rows row..row + count - 1, count <= kRows, from the stored rows row - 5..row + count + 4.
  // derive(stored) gives the N fields from the stored ones; out(row, column, access, blurred) takes them, along a row
  // from left to right; end_row(row) follows each row.
  template <class Derive, class Out, class EndRow>
  void Block(int row, int count, const Derive& derive, const Out& out, const EndRow& end_row) {
    Down(row, InputEnd(row + count), derive);
    for (int r = 0; r < count; ++r) {
      Along(row + r, down_ + Index{r * N} * stride_, out);
      end_row(row + r);
    }
  }

 private:
  static constexpr int kRing = 24;
  static constexpr int kLanes = static_cast<int>(V::size);
  static constexpr int kInputRows = kRows + 2 * kWindowRadius;
  // Vectors made together along a row: enough independent sums to hide the latency of a fused multiply-add, and of what
  // follows the blur.
  static constexpr int kVectorsAlong = N == 1 || (N <= 4 && sizeof(V) == 64) ? 4 : 1;

  // First half, down the columns; rows from `end` on count as zero.
  template <class Derive>
  VESTA_FLATTEN void Down(int row, int end, const Derive& derive) {
    const S* source[kInputRows][kStored];
    for (int k = 0; k < kInputRows; ++k) {
      const int from = row + k - kWindowRadius;
      for (int n = 0; n < kStored; ++n) source[k][n] = from >= 0 && from < end ? Row(from, n) : zeros_;
    }
    constexpr int kVectors = N == 1 ? 2 : 1;
    constexpr WholeVectors<S, kVectors> access;
    using T = typename WholeVectors<S, kVectors>::T;
    for (int column = 0; column < width_; column += kVectors * kLanes) {
      T sum[kRows][N];
      Unrolled<kInputRows>([&](auto k) {
        Fields<kStored, T> stored;
        Unrolled<kStored>([&](auto n) { stored.f[n] = access.LoadAligned(source[k][n] + column); });
        const Fields<N, T> value = derive(stored);
        Unrolled<kRows>([&](auto r) { Unrolled<N>([&](auto n) { Add<k - r>(sum[r][n], value.f[n]); }); });
      });
      Unrolled<kRows>([&](auto r) {
        Unrolled<N>([&](auto n) { access.StoreAligned(down_ + Index{r * N + n} * stride_ + column, sum[r][n]); });
      });
    }
  }

  // Second half, along row `row`, from N rows that begin at `source`.
  template <class Out>
  VESTA_FLATTEN void Along(int row, const S* source, const Out& out) {
    ForColumns<kVectorsAlong, S>(width_, [&](int column, auto access) {
      using T = Several<V, kVectorsAlong>;
      Fields<N, T> sum;
      Unrolled<N>([&](auto n) {
        const Neighbours<S, kVectorsAlong> row_of(source + n * stride_ + column);
        Unrolled<kWindowTaps>([&](auto k) { Add<k>(sum.f[n], row_of.template At<k - kWindowRadius>()); });
      });
      out(row, column, access, sum);
    });
  }

  // sum (+)= the window's weight k * value; no such weight: nothing.
  template <int k, class T>
  void Add(T& sum, const T& value) const {
    if constexpr (k >= 0 && k < kWindowTaps) {
      const T tap = Tap<T>(k < kWindowRadius ? kWindowRadius - k : k - kWindowRadius);
      if constexpr (k == 0) {
        sum = tap * value;
      } else {
        sum = Fma(tap, value, sum);
      }
    }
  }
  template <class T>
  T Tap(int distance) const {
    T tap;
    for (V& v : tap.v) v = tap_[distance];
    return tap;
  }

  int width_, height_;
  Index stride_;
  S *ring_, *down_, *zeros_;
  V tap_[kWindowRadius + 1];
};

// The unblurred rows of a blur, read from images in order and as far as they are asked for. load(position, access)
// gives the kStored fields at the vector of pixels that starts at `position` of the images.
template <int kStored, int N, class S, class Load>
class ImageRows {
 public:
  ImageRows(const RowRange<S>& rows, WindowBlur<kStored, N, S>& blur, int begin, const Load& load)
      : rows_(rows), blur_(blur), next_(begin), load_(load) {}

  // Puts all rows before `end` into the blur's ring.
  VESTA_FLATTEN void MakeUpTo(int end) {
    for (; next_ < end; ++next_) {
      S* target[kStored];
      for (int n = 0; n < kStored; ++n) target[n] = blur_.Row(next_, n);
      const Index position = PositionOf(rows_, next_, 0);
      ForColumns<4, S>(rows_.width, [&](int column, auto access) {
        const auto fields = load_(position + column, access);
        Unrolled<kStored>([&](auto n) { access.StoreAligned(target[n] + column, fields.f[n]); });
      });
    }
  }

 private:
  const RowRange<S>& rows_;
  WindowBlur<kStored, N, S>& blur_;
  int next_;
  const Load& load_;
};

// The blurred rows begin..end - 1 of a blur, made in order and as far as they are asked for, from `source` (ImageRows,
// or BlurredRows that write into this blur's ring). derive, out, end_row: see WindowBlur::Block.
template <class Source, class Blur, class Derive, class Out, class EndRow>
class BlurredRows {
 public:
  BlurredRows(Source& source, Blur& blur, int begin, int end, const Derive& derive, const Out& out,
              const EndRow& end_row)
      : source_(source), blur_(blur), next_(begin), end_(end), derive_(derive), out_(out), end_row_(end_row) {}

  // Makes all rows before `end`, and perhaps a few more; none twice.
  void MakeUpTo(int end) {
    while (next_ < end) {
      const int count = end_ - next_ < Blur::kRows ? end_ - next_ : Blur::kRows;
      source_.MakeUpTo(blur_.InputEnd(next_ + count));
      blur_.Block(next_, count, derive_, out_, end_row_);
      next_ += count;
    }
  }

 private:
  Source& source_;
  Blur& blur_;
  int next_, end_;
  const Derive& derive_;
  const Out& out_;
  const EndRow& end_row_;
};

}  // namespace VESTA_ISA
}  // namespace vesta
