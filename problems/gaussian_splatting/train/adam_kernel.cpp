#include "problems/gaussian_splatting/train/adam_kernel.h"

namespace vesta {

inline namespace baseline {
gs::AdamUpdate CompiledAdamUpdate();
}
#if defined(__x86_64__)
namespace avx2 {
gs::AdamUpdate CompiledAdamUpdate();
}
namespace avx512 {
gs::AdamUpdate CompiledAdamUpdate();
}
#endif

gs::AdamUpdate gs::AdamUpdateFor(Isa isa) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::kAvx512:
      return vesta::avx512::CompiledAdamUpdate();
    case Isa::kAvx2:
      return vesta::avx2::CompiledAdamUpdate();
#endif
    default:
      return vesta::baseline::CompiledAdamUpdate();
  }
}

}  // namespace vesta
