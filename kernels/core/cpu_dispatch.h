// SPDX-License-Identifier: Apache-2.0
// Which of the compiled instruction sets this process uses.
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
