#include "solver/sparse_cholesky/front_kernels.h"

#include "kernels/math/isa.h"

namespace vesta {

// Defined by front_kernels.simd.cpp, once in each namespace.
inline namespace baseline {
const FrontKernels& CompiledFrontKernels();
}  // namespace baseline

#if defined(__x86_64__)
namespace avx2 {
const FrontKernels& CompiledFrontKernels();
}  // namespace avx2
namespace avx512 {
const FrontKernels& CompiledFrontKernels();
}  // namespace avx512
#endif

const FrontKernels& FrontKernelsFor([[maybe_unused]] Isa isa) {
#if defined(__x86_64__)
  if (isa == Isa::kAvx512) return avx512::CompiledFrontKernels();
  if (isa == Isa::kAvx2) return avx2::CompiledFrontKernels();
#endif
  return baseline::CompiledFrontKernels();
}

}  // namespace vesta
