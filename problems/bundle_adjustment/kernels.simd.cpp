// SPDX-License-Identifier: Apache-2.0
// The passes, compiled once for each instruction set (cmake/Targets.cmake, vesta_simd_sources).
#include "problems/bundle_adjustment/camera_passes.h"
#include "problems/bundle_adjustment/point_passes.h"
#include "problems/bundle_adjustment/reduced_passes.h"

namespace vesta::bundle {
inline namespace VESTA_ISA {
namespace {

template <class S>
constexpr Kernels<S> kKernels = {SquaredNorms, Linearize<S>, ApplyJ<S>,         ApplyJT<S>,   ApplyH<S>,
                                 PointGram<S>, Reduce<S>,    BackSubstitute<S>, ReducedRow<S>};

}  // namespace

template <class S>
const Kernels<S>& CompiledKernels() {
  return kKernels<S>;
}
template const Kernels<float>& CompiledKernels<float>();
template const Kernels<double>& CompiledKernels<double>();

SymmetricProduct CompiledSymmetricProduct() { return MultiplySymmetric; }

}  // namespace VESTA_ISA
}  // namespace vesta::bundle
