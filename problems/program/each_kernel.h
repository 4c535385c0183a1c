// SPDX-License-Identifier: Apache-2.0
// The loop of SolveEach, compiled once per instruction set.
#pragma once

#include <span>
#include <vector>

#include "kernels/core/cpu_dispatch.h"
#include "problems/program/differentiate.h"
#include "problems/program/solve_each.h"

namespace vesta::program {

struct EachWork {
  const EachProblem& problem;
  const ProgramPlan& plan;  // of the residual and its derivatives
  std::span<const JacobianEntry> entries;
  const LmOptions& options;
  double* x;
  SmallSummary* summaries;
};

// Solves the problems begin, ..., end - 1.
using SolveEachRange = void(const EachWork& work, Index begin, Index end);
SolveEachRange* SolveEachRangeFor(Isa isa);

}  // namespace vesta::program
