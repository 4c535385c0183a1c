// SPDX-License-Identifier: Apache-2.0
// The compiled instruction sets: which one this process uses, and the tables of functions chosen by it.
#pragma once

namespace vesta {

enum class Isa { kBaseline, kAvx2, kAvx512 };

// The best instruction set of this CPU that was compiled in, or the one that the environment variable
// VESTA_SIMD=sse2|avx2|avx512 forces. Throws Error when the forced one is unknown or the CPU lacks it.
// Decided once a process.
Isa ActiveIsa();
// Whether this CPU has it.
bool IsaAvailable(Isa isa);
const char* IsaName(Isa isa);

}  // namespace vesta

// What a *.simd.cpp defines once per instruction set, declared and chosen: one line each, in the .cpp beside it.
//
//   VESTA_DECLARE_PER_ISA(const RowKernels& CompiledRowKernels();)
//   const RowKernels& RowKernelsFor(Isa isa) { return VESTA_OF_ISA(isa, CompiledRowKernels)(); }
//
// Both stand in the namespace of the *.simd.cpp's own `inline namespace VESTA_ISA`. Not in a header that the
// *.simd.cpp includes: there another of these namespaces is the inline one.
#if defined(__x86_64__)
#define VESTA_DECLARE_PER_ISA(...) \
  inline namespace baseline {      \
  __VA_ARGS__                      \
  }                                \
  namespace avx2 {                 \
  __VA_ARGS__                      \
  }                                \
  namespace avx512 {               \
  __VA_ARGS__                      \
  }
// The function of that name which was compiled for `isa`, which the CPU must have.
#define VESTA_OF_ISA(isa, ...) ::vesta::PickOfIsa(isa, &baseline::__VA_ARGS__, &avx2::__VA_ARGS__, &avx512::__VA_ARGS__)
#else
#define VESTA_DECLARE_PER_ISA(...) \
  inline namespace baseline {      \
  __VA_ARGS__                      \
  }
#define VESTA_OF_ISA(isa, ...) ::vesta::PickOfIsa(isa, &baseline::__VA_ARGS__)
#endif

namespace vesta {

template <class Function, class... Wider>
constexpr Function* PickOfIsa(Isa isa, Function* baseline, Wider*... wider) {
  Function* const compiled[] = {baseline, wider...};  // in the order of Isa
  return compiled[static_cast<int>(isa)];
}

}  // namespace vesta
