// SPDX-License-Identifier: Apache-2.0
#include "bench/kernel_times/vector_rate.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "kernels/core/check.h"
#include "kernels/core/cpu_dispatch.h"

namespace vesta::bench {

VESTA_DECLARE_PER_ISA(float MultiplyAdds(long count);)

double VectorOperationsPerNanosecond(Isa isa) {
  constexpr long kCount = 2'000'000;
  double best = 0;
  for (int run = 0; run < 5; ++run) {
    const auto begin = std::chrono::steady_clock::now();
    const float result = VESTA_OF_ISA(isa, MultiplyAdds)(kCount);
    const double ns = std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count();
    VESTA_CHECK(std::isfinite(result), "sums that converge gave {}", result);
    best = std::max(best, 12 * kCount / ns);
  }
  return best;
}

}  // namespace vesta::bench
