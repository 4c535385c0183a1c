// SPDX-License-Identifier: Apache-2.0
// Selects the SIMD instruction set of this process, and the functions compiled for it.
#pragma once

namespace vesta {

enum class Isa { kBaseline, kAvx2, kAvx512 };

// The best instruction set that this CPU supports and vesta was compiled for. The environment variable
// VESTA_SIMD=sse2|avx2|avx512 (on ARM: neon) overrides this choice. Throws Error if its value is unknown or the CPU
// lacks that set. The choice is made once per process.
Isa ActiveIsa();
// Whether this CPU supports the instruction set.
bool IsaAvailable(Isa isa);
const char* IsaName(Isa isa);

}  // namespace vesta

// VESTA_DECLARE_PER_ISA declares a function that a *.simd.cpp file defines once per instruction set. VESTA_OF_ISA
// selects one of these versions. The ordinary.cpp file uses both macros:
//
//   VESTA_DECLARE_PER_ISA(const RowKernels& CompiledRowKernels();)
//   const RowKernels& RowKernelsFor(Isa isa) { return VESTA_OF_ISA(isa, CompiledRowKernels)(); }
//
// Both lines must be in the namespace that encloses `inline namespace VESTA_ISA` in the *.simd.cpp file. The *.simd.cpp
// file must not include these lines: the macro makes `baseline` the inline namespace, but in the *.simd.cpp file this
// must be VESTA_ISA.
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
// The version compiled for `isa`, which the CPU must support.
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
