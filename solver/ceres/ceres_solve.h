// SPDX-License-Identifier: Apache-2.0
// Functions that solve a ceres::Problem with vesta instead of ceres::Solve.
#pragma once

#include <ceres/ceres.h>

#include <string>
#include <vector>

#include "solver/levenberg_marquardt.h"

namespace vesta::ceres_bridge {

// Minimises `problem` from the current values of its parameter blocks, and writes the best x found to them. As in
// Ceres, a start that violates bounds is projected onto them; the report then contains a note. If a constant block
// violates its bounds, or a lower bound is above the upper bound, the solve ends before the first iteration
// (kInfeasible). Equal bounds keep an entry at that value; Ceres refuses equal bounds. Invalid options end the solve
// before the cost is evaluated (kInvalidOptions).
LmSummary Solve(const LmOptions& options, ceres::Problem& problem, const LmCallback& callback = {});

// The same with ceres::Solver::Options, for which IsValid must return true. Supported options are
// update_state_every_iteration, `callbacks`, and those converted by FromCeres. The report lists the options that are
// ignored. As in Ceres, callbacks are called once before the first iteration and then after each iteration. Their
// IterationSummary is complete except for gradient_norm, the line-search members and step_solver_time_in_seconds. If a
// callback returns SOLVER_ABORT, the parameter blocks keep the start values, or with update_state_every_iteration the
// values of the last iteration. evaluation_callback: the member of ceres::Problem::Options, which cannot be read from a
// ceres::Problem.
LmSummary Solve(const ceres::Solver::Options& options, ceres::Problem& problem, const LmCallback& callback = {},
                ceres::EvaluationCallback* evaluation_callback = nullptr);

// Converts the options of Ceres's Levenberg-Marquardt method: tolerances, limits, trust-region radius (1/lambda),
// min_lm_diagonal and max_lm_diagonal, Jacobi scaling and the type of linear solver. Options without a counterpart are
// ignored.
LmOptions FromCeres(const ceres::Solver::Options& options);

// Returns one line for each option that is ignored although its value is not the default. The line contains the name of
// the option and the behaviour of vesta.
std::vector<std::string> IgnoredOptions(const ceres::Solver::Options& options);

}  // namespace vesta::ceres_bridge
