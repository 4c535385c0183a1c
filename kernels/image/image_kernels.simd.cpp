// SPDX-License-Identifier: Apache-2.0
#include "kernels/image/image_kernels.h"

#include "kernels/image/gradient_loops.h"

namespace vesta {
inline namespace VESTA_ISA {
namespace {

template <class S>
constexpr ImageKernels<S> kKernels{&Value<S>, &Gradient<S>, &Center<S>, &Curvature<S>};

}  // namespace

template <class S>
const ImageKernels<S>& CompiledImageKernels() {
  return kKernels<S>;
}

template const ImageKernels<float>& CompiledImageKernels<float>();
template const ImageKernels<double>& CompiledImageKernels<double>();

}  // namespace VESTA_ISA
}  // namespace vesta
