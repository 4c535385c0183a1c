#include "kernels/image/image_kernels.h"

#include "kernels/math/isa.h"

namespace vesta {

// Defined by image_kernels.simd.cpp, once in each namespace.
inline namespace baseline {
template <class S>
const ImageKernels<S>& CompiledImageKernels();
}  // namespace baseline

#if defined(__x86_64__)
namespace avx2 {
template <class S>
const ImageKernels<S>& CompiledImageKernels();
}  // namespace avx2
namespace avx512 {
template <class S>
const ImageKernels<S>& CompiledImageKernels();
}  // namespace avx512
#endif

template <class S>
const ImageKernels<S>& ImageKernelsFor([[maybe_unused]] Isa isa) {
#if defined(__x86_64__)
  if (isa == Isa::kAvx512) return avx512::CompiledImageKernels<S>();
  if (isa == Isa::kAvx2) return avx2::CompiledImageKernels<S>();
#endif
  return baseline::CompiledImageKernels<S>();
}

template const ImageKernels<float>& ImageKernelsFor<float>(Isa);
template const ImageKernels<double>& ImageKernelsFor<double>(Isa);

}  // namespace vesta
