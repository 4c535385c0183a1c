// SPDX-License-Identifier: Apache-2.0
// tools/check_isa_symbols.py must report one symbol here: an inline function outside the inline namespace of its
// instruction set.
#include "kernels/math/isa.h"

namespace vesta {

[[gnu::noinline]] inline float PlantedOutside(float x) { return x * x + 1.0F; }

inline namespace VESTA_ISA {

[[gnu::noinline]] inline float PlantedInside(float x) { return PlantedOutside(x) - x; }

float UsePlanted(float x) { return PlantedInside(x); }

}  // namespace VESTA_ISA
}  // namespace vesta
