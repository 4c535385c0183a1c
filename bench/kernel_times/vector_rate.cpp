#include "bench/kernel_times/vector_rate.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "kernels/core/check.h"

namespace vesta {

inline namespace baseline {
float MultiplyAdds(long count);
}
#if defined(__x86_64__)
namespace avx2 {
float MultiplyAdds(long count);
}
namespace avx512 {
float MultiplyAdds(long count);
}
#endif

namespace bench {

double VectorOperationsPerNanosecond(Isa isa) {
  constexpr long kCount = 2'000'000;
  double best = 0;
  for (int run = 0; run < 5; ++run) {
    const auto begin = std::chrono::steady_clock::now();
    float result = 0;
    switch (isa) {
#if defined(__x86_64__)
      case Isa::kAvx512:
        result = avx512::MultiplyAdds(kCount);
        break;
      case Isa::kAvx2:
        result = avx2::MultiplyAdds(kCount);
        break;
#endif
      default:
        result = baseline::MultiplyAdds(kCount);
    }
    const double ns = std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count();
    VESTA_CHECK(std::isfinite(result), "sums that converge gave {}", result);
    best = std::max(best, 12 * kCount / ns);
  }
  return best;
}

}  // namespace bench
}  // namespace vesta
