// SPDX-License-Identifier: Apache-2.0
#include "problems/program/run_program.h"

#include "problems/program/run_steps.h"

namespace vesta {
inline namespace VESTA_ISA {

void CompiledRunSteps(std::span<const program::Step> steps, double* const* arrays) { RunStepsHere(steps, arrays); }

}  // namespace VESTA_ISA
}  // namespace vesta
