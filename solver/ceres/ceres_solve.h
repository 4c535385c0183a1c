// SPDX-License-Identifier: Apache-2.0
// ceres::Solve's counterparts.
#pragma once

#include <ceres/ceres.h>

#include <string>
#include <vector>

#include "solver/levenberg_marquardt.h"

namespace vesta::ceres_bridge {

// Minimises `problem` from the values its parameter blocks hold; they hold the best x met afterwards. As with Ceres, a
// start outside of its bounds is projected onto them (the report has a note), and a constant block outside of its
// bounds ends the solve before it begins (kInfeasible).
LmSummary Solve(const LmOptions& options, ceres::Problem& problem, const LmCallback& callback = {});

// The same with ceres::Solver::Options: what FromCeres takes over; `callbacks`, called as Ceres calls them after the
// start and after each iteration, with all members of IterationSummary but gradient_norm, those of a line search and
// step_solver_time_in_seconds; update_state_every_iteration. What is ignored is noted in the report. A callback that
// returns SOLVER_ABORT leaves the parameter blocks as they were, or as the last update of the state has left them.
// ceres::Problem does not tell which evaluation callback it has (Problem::Options): give it here again.
LmSummary Solve(const ceres::Solver::Options& options, ceres::Problem& problem, const LmCallback& callback = {},
                ceres::EvaluationCallback* evaluation_callback = nullptr);

// vesta's options for what ceres::Solver::Options asks of a trust-region LM: tolerances, limits, radius (1/lambda), the
// range of the diagonal, Jacobi scaling and the linear solver's kind. What has no counterpart is ignored.
LmOptions FromCeres(const ceres::Solver::Options& options);

// A line for each option that is not at its default and has no effect here: what it is, and what happens instead.
std::vector<std::string> IgnoredOptions(const ceres::Solver::Options& options);

}  // namespace vesta::ceres_bridge
