// SPDX-License-Identifier: Apache-2.0
// Counterparts of ceres::Solve.
#pragma once

#include <ceres/ceres.h>

#include <string>
#include <vector>

#include "solver/levenberg_marquardt.h"

namespace vesta::ceres_bridge {

// Minimises `problem` from the current values of its parameter blocks, and writes the best x found to them. As in
// Ceres, a start outside the bounds is projected onto them, with a note in the report. A constant block outside its
// bounds ends the solve before the first iteration (kInfeasible).
LmSummary Solve(const LmOptions& options, ceres::Problem& problem, const LmCallback& callback = {});

// The same with ceres::Solver::Options. It supports the options that FromCeres converts, update_state_every_iteration
// and `callbacks`. The report lists the options that are ignored. Callbacks are called after the start and after each
// iteration, as in Ceres. Their IterationSummary is complete except for gradient_norm, the line-search members and
// step_solver_time_in_seconds. If a callback returns SOLVER_ABORT, the parameter blocks keep their values from the
// start, or from the last state update. Pass the evaluation callback of
// Problem::Options here again, because it cannot be read from a ceres::Problem.
LmSummary Solve(const ceres::Solver::Options& options, ceres::Problem& problem, const LmCallback& callback = {},
                ceres::EvaluationCallback* evaluation_callback = nullptr);

// Converts the options of Ceres's trust-region Levenberg-Marquardt: tolerances, limits, radius (1/lambda), the range of
// the diagonal, Jacobi scaling and the kind of linear solver. Options without a counterpart are ignored.
LmOptions FromCeres(const ceres::Solver::Options& options);

// Returns one line for each option that is not at its default and is ignored: its name, and what happens instead.
std::vector<std::string> IgnoredOptions(const ceres::Solver::Options& options);

}  // namespace vesta::ceres_bridge
