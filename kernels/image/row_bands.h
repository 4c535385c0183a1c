// Runs an image kernel over all rows of a plane, in parallel, with scratch memory that is reused from call to call.
#pragma once

#include <array>
#include <functional>

#include "kernels/core/buffer.h"
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
  // Allocates when the shape changes. Throws Error unless width and height are at least 1.
  void Resize(const ImageShape& shape);

  // Runs `kernel`, one of the members of ImageKernels, on planes of the current shape.
  template <class Args>
  void Run(void (*ImageKernels<S>::*kernel)(const RowRange<S>&, const Args&), const Args& args) {
    Run(kernel, args, taps_);
  }
  // The same with the squares of the window's weights in place of the weights.
  template <class Args>
  void RunSquared(void (*ImageKernels<S>::*kernel)(const RowRange<S>&, const Args&), const Args& args) {
    Run(kernel, args, squared_taps_);
  }

 private:
  using Taps = std::array<S, kWindowTaps + 2>;  // a zero at either end

  // Rows in one task: even (image_kernels.h), few enough for all threads to have some.
  static constexpr Index kBandRows = 16;

  template <class Args>
  void Run(void (*ImageKernels<S>::*kernel)(const RowRange<S>&, const Args&), const Args& args, const Taps& taps) {
    const auto band = [&](Index begin, Index end) {
      S* scratch = scratch_.data() + begin / kBandRows * band_stride_ + RowRange<S>::kScratchPad;
      const RowRange<S> rows{shape_.width,    shape_.height, static_cast<int>(begin), static_cast<int>(end),
                             taps.data() + 1, scratch,       scratch_stride_};
      (kernels_.*kernel)(rows, args);
    };
    ParallelForChunks(shape_.height, kBandRows, std::cref(band));  // by reference: nothing is allocated
  }

  const ImageKernels<S>& kernels_;
  Taps taps_{}, squared_taps_{};
  ImageShape shape_;
  Index scratch_stride_ = 0, band_stride_ = 0;
  HostBuffer<S> scratch_;
};

}  // namespace vesta
