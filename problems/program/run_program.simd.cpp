// SPDX-License-Identifier: Apache-2.0
#include "problems/program/run_program.h"

#include <algorithm>

#include "kernels/math/double_lanes.h"
#include "problems/program/operation_formula.h"

namespace vesta {
inline namespace VESTA_ISA {

void CompiledRunSteps(std::span<const program::Step> steps, double* const* arrays) {
  using V = DoubleLanes;
  for (const program::Step& step : steps) {
    double* const to = arrays[step.result];
    const double* const a = arrays[step.a];
    const double* const b = arrays[step.b];
    const double* const c = arrays[step.c];
    if (step.operation == program::Operation::kInput) {
      std::copy_n(a, program::kChunk, to);
      continue;
    }
    const auto load = [](const double* from) { return V(*reinterpret_cast<const V::Vector*>(from)); };
    WithFormula<V>(step.operation, [&](const auto& formula) {
      for (int i = 0; i < program::kChunk; i += V::kWidth) {
        *reinterpret_cast<V::Vector*>(to + i) = formula(load(a + i), load(b + i), load(c + i)).v;
      }
    });
  }
}

}  // namespace VESTA_ISA
}  // namespace vesta
