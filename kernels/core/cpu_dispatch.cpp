// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/cpu_dispatch.h"

#include <cstdlib>
#include <string_view>

#include "kernels/core/check.h"

namespace vesta {

bool IsaAvailable(Isa isa) {
#if defined(__x86_64__)
  __builtin_cpu_init();
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
                      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
                      __builtin_cpu_supports("avx512vl");
  return isa == Isa::kBaseline || (isa == Isa::kAvx2 && avx2) || (isa == Isa::kAvx512 && avx2 && avx512);
#else
  return isa == Isa::kBaseline;
#endif
}

namespace {

Isa Choose() {
  const char* forced = std::getenv("VESTA_SIMD");
  if (forced != nullptr && *forced != '\0') {
    const std::string_view name(forced);
    for (const Isa isa : {Isa::kBaseline, Isa::kAvx2, Isa::kAvx512}) {
      if (name != IsaName(isa)) continue;
      if (!IsaAvailable(isa)) Fail(kUnavailable, "VESTA_SIMD={}: this CPU does not have it; unset VESTA_SIMD", name);
      return isa;
    }
    Fail(kBadArgument, "VESTA_SIMD={}: not one of {}, avx2, avx512", name, IsaName(Isa::kBaseline));
  }
  return IsaAvailable(Isa::kAvx512) ? Isa::kAvx512 : IsaAvailable(Isa::kAvx2) ? Isa::kAvx2 : Isa::kBaseline;
}

}  // namespace

Isa ActiveIsa() {
  static const Isa isa = Choose();
  return isa;
}

const char* IsaName(Isa isa) {
  switch (isa) {
    case Isa::kAvx2:
      return "avx2";
    case Isa::kAvx512:
      return "avx512";
    default:
#if defined(__x86_64__)
      return "sse2";
#elif defined(__aarch64__)
      return "neon";
#else
      return "baseline";
#endif
  }
}

}  // namespace vesta
