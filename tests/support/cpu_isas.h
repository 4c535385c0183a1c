// SPDX-License-Identifier: Apache-2.0
// The instruction sets of this CPU, for tests of the code compiled for each.
#pragma once

#include <vector>

#include "kernels/core/cpu_dispatch.h"

namespace vesta::test {

inline std::vector<Isa> CpuIsas() {
  std::vector<Isa> isas = {Isa::kBaseline};
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    isas.push_back(Isa::kAvx2);
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) {
      isas.push_back(Isa::kAvx512);
    }
  }
#endif
  return isas;
}

}  // namespace vesta::test
