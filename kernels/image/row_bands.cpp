#include "kernels/image/row_bands.h"

#include "kernels/core/check.h"

namespace vesta {

template <class S>
RowBands<S>::RowBands(Isa isa) : kernels_(ImageKernelsFor<S>(isa)) {
  const auto taps = GaussianTaps();
  for (std::size_t k = 0; k < taps.size(); ++k) {
    taps_[k + 1] = static_cast<S>(taps[k]);
    squared_taps_[k + 1] = static_cast<S>(taps[k] * taps[k]);
  }
}

template <class S>
void RowBands<S>::Resize(const ImageShape& shape) {
  VESTA_CHECK(shape.width >= 1 && shape.height >= 1, "an image of {} x {} pixels", shape.width, shape.height);
  if (shape == shape_) return;
  constexpr Index kPad = RowRange<S>::kScratchPad;
  shape_ = shape;
  scratch_stride_ = (shape.width + kPad - 1) / kPad * kPad + 2 * kPad;
  band_stride_ = RowRange<S>::kScratchRows * scratch_stride_;
  const Index bands = (shape.height + kBandRows - 1) / kBandRows;
  scratch_.Resize(bands * band_stride_);
}

template class RowBands<float>;
template class RowBands<double>;

}  // namespace vesta
