// SPDX-License-Identifier: Apache-2.0
// Bodies of the templates of bench/deconvolution/coded_blur.h.
#pragma once

#include "bench/deconvolution/coded_blur.h"
#include "kernels/core/parallel.h"

namespace vesta::deconvolution {

template <class Value>
void CodedBlur::SetImage(const Value& value) {
  const Index stride = side_ + 2 * kSpill;
  ParallelFor(side_, 16, [&](Index row) {
    double* out = padded_image_.data() + (row + kSpill) * stride + kSpill;
    for (Index j = 0; j < side_; ++j) out[j] = value(row * side_ + j);
  });
}

template <class Value>
void CodedBlur::SetFrame(const Value& value) {
  ParallelFor(frame_size(), 16384, [&](Index i) { frame_[i] = value(i); });
}

}  // namespace vesta::deconvolution
