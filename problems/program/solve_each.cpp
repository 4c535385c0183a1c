// SPDX-License-Identifier: Apache-2.0
#include "problems/program/solve_each.h"

#include <fmt/format.h>

#include <cstddef>

#include "kernels/core/error.h"
#include "kernels/core/parallel.h"
#include "problems/program/each_kernel.h"
#include "solver/internal/small/small_loop.h"

namespace vesta {

VESTA_DECLARE_PER_ISA(void CompiledSolveEachRange(const program::EachWork& work, Index begin, Index end);)

namespace program {

SolveEachRange* SolveEachRangeFor(Isa isa) { return VESTA_OF_ISA(isa, CompiledSolveEachRange); }

std::vector<SmallSummary> SolveEach(const EachProblem& problem, std::span<double> x, const LmOptions& options) {
  small_internal::CheckSmallOptions(options);
  const int n = problem.num_parameters;
  if (n < 1 || n > kMaxEachParameters) {
    throw Error(kUnsupported,
                fmt::format("each problem has {} parameters; 1 to {} are supported", n, kMaxEachParameters));
  }
  const Index count = static_cast<Index>(x.size()) / n;
  bool fits = count * n == static_cast<Index>(x.size()) && problem.num_residuals > 0 &&
              problem.residual.outputs.size() == 1 &&
              problem.residual.num_inputs == n + static_cast<int>(problem.data.size());
  for (const std::span<const double> data : problem.data) {
    fits = fits && static_cast<Index>(data.size()) == count * problem.num_residuals;
  }
  if (!fits) throw Error(kBadArgument, "the start values, the data and the program do not fit each other");
  const Derivatives derivatives = Differentiate(problem.residual, n);
  const ProgramPlan plan(derivatives.program);
  std::vector<SmallSummary> summaries(static_cast<std::size_t>(count));
  const EachWork work{problem, plan, derivatives.entries, options, x.data(), summaries.data()};
  SolveEachRange* const solve = SolveEachRangeFor(ActiveIsa());
  constexpr Index kGrain = 256;  // long enough to keep all lanes busy
  ParallelForChunks(count, kGrain, [&](Index begin, Index end) { solve(work, begin, end); });
  return summaries;
}

}  // namespace program
}  // namespace vesta
