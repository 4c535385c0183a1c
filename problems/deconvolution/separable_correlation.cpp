#include "problems/deconvolution/separable_correlation.h"

#include "kernels/math/isa.h"

namespace vesta {

// Defined by separable_correlation.simd.cpp, once in each namespace.
inline namespace baseline {
deconvolution::CorrelateRows CompiledCorrelateRows();
}  // namespace baseline

#if defined(__x86_64__)
namespace avx2 {
deconvolution::CorrelateRows CompiledCorrelateRows();
}  // namespace avx2
namespace avx512 {
deconvolution::CorrelateRows CompiledCorrelateRows();
}  // namespace avx512
#endif

namespace deconvolution {

CorrelateRows CorrelateRowsFor([[maybe_unused]] Isa isa) {
#if defined(__x86_64__)
  if (isa == Isa::kAvx512) return avx512::CompiledCorrelateRows();
  if (isa == Isa::kAvx2) return avx2::CompiledCorrelateRows();
#endif
  return baseline::CompiledCorrelateRows();
}

}  // namespace deconvolution
}  // namespace vesta
