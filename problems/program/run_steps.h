// SPDX-License-Identifier: Apache-2.0
// RunSteps for the instruction set of the including file (*.simd.cpp).
#pragma once

#include <algorithm>
#include <span>

#include "kernels/math/double_lanes.h"
#include "problems/program/operation_formula.h"
#include "problems/program/run_program.h"

namespace vesta {
inline namespace VESTA_ISA {

inline void RunStepsHere(std::span<const program::Step> steps, double* const* arrays) {
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
