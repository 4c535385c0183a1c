// SPDX-License-Identifier: Apache-2.0
#include "kernels/image/row_bands.h"

#include "kernels/core/buffer.h"
#include "kernels/core/check.h"

namespace vesta {

template <class S>
RowBands<S>::RowBands(Isa isa) : kernels_(ImageKernelsFor<S>(isa)) {
  const auto taps = GaussianTaps();
  for (std::size_t k = 0; k < taps.size(); ++k) taps_[k] = static_cast<S>(taps[k]);
}

template <class S>
void RowBands<S>::Resize(const ImageShape& shape) {
  VESTA_CHECK(shape.width >= 1 && shape.height >= 1, "an image of {} x {} pixels", shape.width, shape.height);
  shape_ = shape;
  bands_ = (shape.height + kBandRows - 1) / kBandRows;
  const int rows = (shape.height + bands_ - 1) / bands_;
  band_rows_ = (rows + kBandUnit - 1) / kBandUnit * kBandUnit;
}

template <class S>
S* RowBands<S>::Scratch() const {
  thread_local HostBuffer<S> scratch;
  const Index size = RowRange<S>::kScratchRows * ScratchStride(shape_.width);
  if (scratch.size() < size) scratch.ResizeForOverwrite(size);
  return scratch.data();
}

template class RowBands<float>;
template class RowBands<double>;

}  // namespace vesta
