// SPDX-License-Identifier: Apache-2.0
// The status and statistics that a solve returns.
#pragma once

#include <string>
#include <vector>

#include "kernels/core/profile.h"
#include "kernels/core/span.h"
#include "solver/internal/linear/pcg.h"

namespace vesta {

enum class LmStatus {
  kRunning,
  // Converged.
  kFunctionTolerance,
  kGradientTolerance,
  kParameterTolerance,
  // Stopped.
  kMaxIterations,
  kTimeLimit,
  kStoppedByCallback,
  // lambda is at its upper bound, too many steps in a row were rejected, or no step decreased the cost as predicted.
  kNoDecrease,
  // Failed: the problem or the start is not valid; the message says what to do.
  kInfeasible,            // the start violates a bound
  kNonFinite,             // the cost at the start, or a derivative at an x with a finite cost, is NaN or infinite
  kBadDiagonal,           // DiagJTJ returned negative values, NaN or infinity
  kGradientInZeroColumn,  // converged, but a parameter whose DiagJTJ entry is zero has a nonzero gradient
  kDegenerateStart,       // no step can change a parameter block from its start (such as a quaternion of zeros)
  kCheckFailed,           // LmOptions::check_derivatives found a fault
  kInvalidOptions,        // the Ceres bridge was given options out of range; SolveLm throws Error instead
};
const char* ToString(LmStatus status);
// True if one of the three tolerances was met.
bool IsConverged(LmStatus status);
// True if the problem or the start is not valid.
bool IsFailure(LmStatus status);

// Record of one iteration: a solve of the normal equations (one per batch with BatchMode::kMerge), and the trial step
// along its solution.
struct LmIteration {
  int iteration = 0;             // 0 is the start
  double cost = 0;               // cost of x after this iteration, with the fixed cost
  double cost_change = 0;        // cost before minus cost of the trial; may be NaN or infinite
  double rho = 0;                // gain ratio of the trial: decrease of the cost / predicted decrease
  double lambda = 0;             // damping of the linear solve
  double gamma = 0;              // factor on the step, from the line search; 1 without line search
  double gradient_max_norm = 0;  // max |x - (x (+) -g)| before this iteration, as in LmOptions::gradient_tolerance
  double step_norm = 0;          // norm of the trial step, in the tangent space
  int pcg_iterations = 0;        // summed over batches
  PcgStatus pcg_status = PcgStatus::kConverged;  // status of the last batch
  double pcg_residual = 0;  // |residual| / |right-hand side| of the last batch, with scaled columns
  bool accepted = false;
  double seconds = 0;  // since the start of the solve
};

struct LmSummary {
  LmStatus status = LmStatus::kRunning;
  std::string message;      // one line: why the solve ended
  double initial_cost = 0;  // NaN if it was not evaluated (kInvalidOptions)
  double final_cost = 0;
  // The part of all costs in this summary that no step can change, such as the cost of residual blocks whose parameter
  // blocks are all constant. Not saved, because a resumed solve evaluates it again.
  double fixed_cost = 0;
  Index num_parameters = 0;  // number of entries of x
  Index num_tangent = 0;     // number of entries of a step
  Index num_residuals = 0;   // summed over batches, without the residuals of the fixed cost
  int num_batches = 0;
  Index num_zero_columns = 0;  // step entries whose DiagJTJ is not positive in any batch, at the last linearization
  int num_accepted = 0;
  int num_rejected = 0;
  int num_linearizations = 0;      // counted per batch
  int num_cost_evaluations = 0;    // of the cost of all units
  int num_subset_evaluations = 0;  // of the cost of a subset of the units, by the line search
  int num_pcg_iterations = 0;
  int num_products = 0;          // products with H, counted per batch in BatchMode::kMerge
  double linearize_seconds = 0;  // including gradient, diagonal and preconditioner
  double linear_solve_seconds = 0;
  double cost_seconds = 0;
  double total_seconds = 0;
  // The linear solver at the first linearization and, if it was chosen automatically, the reason.
  std::string linear_solver;
  std::string configuration;  // the step rule and other choices, for the full report
  std::vector<LmIteration> iterations;
  // Remarks about the arguments of the call, for the full report; not saved.
  std::vector<std::string> notes = {};
  // Time per phase, if LmOptions::profile is true; not saved.
  std::vector<PhaseRow> phases = {};

  // Saves or loads all members, except if a comment says "not saved" (kernels/core/archive.h).
  template <class Archive>
  void Visit(Archive& archive) {
    archive(status, message, initial_cost, final_cost, num_parameters, num_tangent, num_residuals, num_batches,
            num_zero_columns, num_accepted, num_rejected, num_linearizations, num_cost_evaluations,
            num_subset_evaluations, num_pcg_iterations, num_products, linearize_seconds, linear_solve_seconds,
            cost_seconds, total_seconds, linear_solver, configuration, iterations);
  }

  // One line: status, costs, iterations and seconds.
  std::string BriefReport() const;
  // Sizes, settings, counts, times and a table of the iterations.
  std::string FullReport() const;
};

}  // namespace vesta
