#include "problems/pose_graph/front_kernels.h"

#include "kernels/math/isa.h"

namespace vesta {

// Defined by front_kernels.simd.cpp, once in each namespace.
inline namespace baseline {
const pose_graph::FrontKernels& CompiledFrontKernels();
}  // namespace baseline

#if defined(__x86_64__)
namespace avx2 {
const pose_graph::FrontKernels& CompiledFrontKernels();
}  // namespace avx2
namespace avx512 {
const pose_graph::FrontKernels& CompiledFrontKernels();
}  // namespace avx512
#endif

namespace pose_graph {

const FrontKernels& FrontKernelsFor([[maybe_unused]] Isa isa) {
#if defined(__x86_64__)
  if (isa == Isa::kAvx512) return avx512::CompiledFrontKernels();
  if (isa == Isa::kAvx2) return avx2::CompiledFrontKernels();
#endif
  return baseline::CompiledFrontKernels();
}

}  // namespace pose_graph
}  // namespace vesta
