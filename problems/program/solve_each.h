// SPDX-License-Identifier: Apache-2.0
// Many small problems whose residuals are one program with different data, solved independently (solver/solve_each.h).
#pragma once

#include <span>
#include <vector>

#include "problems/program/program.h"
#include "problems/program/run_program.h"
#include "solver/lm_options.h"
#include "solver/small_summary.h"

namespace vesta::program {

// The largest number of parameters per problem.
inline constexpr int kMaxEachParameters = 12;

// All problems. Each has num_residuals residuals. residual: the program of one residual; its inputs are the parameters
// of the problem, then the residual's data.
struct EachProblem {
  int num_parameters, num_residuals;
  Program residual;
  // Per datum one array with a number per problem and residual: problem * num_residuals + residual.
  std::vector<std::span<const double>> data;
};

// x: num_parameters start values per problem; replaced by the results. Returns one summary per problem. A result
// depends only on its problem, start and options. Throws Error for sizes that do not fit, more than kMaxEachParameters
// parameters, and options that small problems do not have (SmallSolver).
std::vector<SmallSummary> SolveEach(const EachProblem& problem, std::span<double> x, const LmOptions& options = {});

}  // namespace vesta::program
