// SPDX-License-Identifier: Apache-2.0
// Runs an image kernel over all rows of all planes, in parallel.
#pragma once

#include <algorithm>
#include <array>
#include <functional>

#include "kernels/core/parallel.h"
#include "kernels/image/gaussian_window.h"
#include "kernels/image/image_kernels.h"
#include "kernels/image/image_shape.h"

namespace vesta {

// S is float or double. One user at a time.
template <class S>
class RowBands {
 public:
  explicit RowBands(Isa isa);

  const ImageShape& shape() const { return shape_; }
  // Throws Error unless width and height are at least 1.
  void Resize(const ImageShape& shape);

  // Runs `kernel`, one of the members of ImageKernels, on images of the current shape.
  template <class Args>
  void Run(void (*ImageKernels<S>::*kernel)(const RowRange<S>&, const Args&), const Args& args) {
    const auto band = [&](Index task, Index) {
      const int plane = static_cast<int>(task) / bands_, first = static_cast<int>(task) % bands_ * band_rows_;
      const RowRange<S> rows{.width = shape_.width,
                             .height = shape_.height,
                             .plane = plane,
                             .begin = first,
                             .end = std::min(first + band_rows_, shape_.height),
                             .taps = taps_.data(),
                             .scratch = Scratch()};
      (kernels_.*kernel)(rows, args);
    };
    ParallelForChunks(Index{ImageShape::kChannels} * bands_, 1, std::cref(band));  // by reference: nothing is allocated
  }

 private:
  // About the number of rows in one task. Two tasks both compute the ten rows around their border, so a task has many
  // more rows than that, in a multiple of the rows that kernels compute at once.
  static constexpr int kBandRows = 96, kBandUnit = 4;

  // Scratch memory of the calling thread, for images of the current width.
  S* Scratch() const;

  const ImageKernels<S>& kernels_;
  std::array<S, kWindowTaps> taps_{};
  ImageShape shape_;
  int bands_ = 0, band_rows_ = 0;  // of one plane
};

}  // namespace vesta
