// SPDX-License-Identifier: Apache-2.0
// What a solve reports.
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
  kNoDecrease,  // lambda is at its upper bound, too many rejects in a row, or no step kept what the model promised
  // Failed: the problem, or the x given, is not what a solve needs; the message says what to do.
  kInfeasible,            // the x given violates a bound
  kNonFinite,             // the x given, or the derivatives at an x with a finite cost, hold NaN or infinity
  kBadDiagonal,           // DiagJTJ gives what no sum of squares can be: negative, NaN, infinite
  kGradientInZeroColumn,  // nothing else is left to gain, but a column that DiagJTJ says is zero has a gradient
  kDegenerateStart,       // at the x given no step leads anywhere (a quaternion of zeros)
  kCheckFailed,           // LmOptions::check_derivatives has found a fault
};
const char* ToString(LmStatus status);
// One of the three tolerances was met.
bool IsConverged(LmStatus status);
// The problem, or the x given, is not what a solve needs.
bool IsFailure(LmStatus status);

// One iteration: one solve of the (batches') normal equations, and the trial steps along the result.
struct LmIteration {
  int iteration = 0;                             // 0 is the start
  double cost = 0;                               // of the x held after this iteration
  double cost_change = 0;                        // cost before minus cost of the trial; not finite when that is not
  double rho = 0;                                // gain ratio of the trial
  double lambda = 0;                             // that was solved with
  double gamma = 0;                              // factor of the trial step
  double gradient_max_norm = 0;                  // at the x held before
  double step_norm = 0;                          // of the trial step, in the tangent space
  int pcg_iterations = 0;                        // summed over batches
  PcgStatus pcg_status = PcgStatus::kConverged;  // of the last batch
  double pcg_residual = 0;                       // |r| / |b| of the last batch, in the scaled norm
  bool accepted = false;
  double seconds = 0;  // since the start of the solve
};

struct LmSummary {
  LmStatus status = LmStatus::kRunning;
  std::string message;  // one line: why the solve ended
  double initial_cost = 0;
  double final_cost = 0;
  Index num_parameters = 0;
  Index num_tangent = 0;
  Index num_residuals = 0;
  int num_batches = 0;
  Index num_zero_columns = 0;  // columns without a positive entry of DiagJTJ in any batch at the last linearization
  int num_accepted = 0;
  int num_rejected = 0;
  int num_linearizations = 0;    // of a batch
  int num_cost_evaluations = 0;  // over everything
  int num_subset_evaluations = 0;
  int num_pcg_iterations = 0;
  int num_products = 0;          // with H of a batch or of the sum
  double linearize_seconds = 0;  // gradient, diagonal, preconditioner included
  double linear_solve_seconds = 0;
  double cost_seconds = 0;
  double total_seconds = 0;
  std::string linear_solver;  // what solved the steps and, where that was chosen, why
  std::string configuration;  // the chosen parts, for the full report
  std::vector<LmIteration> iterations;
  // Lines for the full report, on how the call that began the solve was understood; not saved.
  std::vector<std::string> notes = {};
  // With LmOptions::profile: where the time of the solve went; not saved.
  std::vector<PhaseRow> phases = {};

  // Every other member, for a solve that is saved and goes on later (kernels/core/archive.h).
  template <class Archive>
  void Visit(Archive& archive) {
    archive(status, message, initial_cost, final_cost, num_parameters, num_tangent, num_residuals, num_batches,
            num_zero_columns, num_accepted, num_rejected, num_linearizations, num_cost_evaluations,
            num_subset_evaluations, num_pcg_iterations, num_products, linearize_seconds, linear_solve_seconds,
            cost_seconds, total_seconds, linear_solver, configuration, iterations);
  }

  // One line.
  std::string BriefReport() const;
  // Sizes, parts, counts, times and a table of the iterations.
  std::string FullReport() const;
};

}  // namespace vesta
