// The passes of one instruction set; compiled once for each (cmake/Targets.cmake, vesta_simd_sources).
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

const Kernels<float>& FloatKernels() { return kKernels<float>; }
const Kernels<double>& DoubleKernels() { return kKernels<double>; }
SymmetricProduct GetSymmetricProduct() { return MultiplySymmetric; }

}  // namespace VESTA_ISA
}  // namespace vesta::bundle
