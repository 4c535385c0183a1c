#include "problems/gaussian_splatting/adam/adam_kernel.h"

namespace vesta {

inline namespace baseline {
gs::AdamKernels CompiledAdamKernels();
}
#if defined(__x86_64__)
namespace avx2 {
gs::AdamKernels CompiledAdamKernels();
}
namespace avx512 {
gs::AdamKernels CompiledAdamKernels();
}
#endif

gs::AdamKernels gs::AdamKernelsFor(Isa isa) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::kAvx512:
      return vesta::avx512::CompiledAdamKernels();
    case Isa::kAvx2:
      return vesta::avx2::CompiledAdamKernels();
#endif
    default:
      return vesta::baseline::CompiledAdamKernels();
  }
}

}  // namespace vesta
