// SPDX-License-Identifier: Apache-2.0
#include "kernels/math/lanes.h"

namespace vesta::bench {
inline namespace VESTA_ISA {

// `count` multiply-adds in each of twelve independent chains, enough to hide the latency. The result depends on all of
// them, so that the compiler keeps them.
float MultiplyAdds(long count) {
  constexpr int kSums = 12;
  FloatLanes sum[kSums];
  for (int k = 0; k < kSums; ++k) sum[k] = FloatLanes(static_cast<float>(k));
  const FloatLanes factor(0.999f), addend(1e-3f);
  for (long i = 0; i < count; ++i) {
    for (FloatLanes& s : sum) s = Fma(s, factor, addend);
  }
  FloatLanes total(0);
  for (const FloatLanes& s : sum) total = total + s;
  float result;
  Lanes<FloatLanes>::SumEach<1>(&total, &result);
  return result;
}

}  // namespace VESTA_ISA
}  // namespace vesta::bench
