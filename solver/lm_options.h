// SPDX-License-Identifier: Apache-2.0
// Options of the Levenberg-Marquardt solver.
#pragma once

#include <functional>
#include <limits>

#include "solver/internal/normal_equations/normal_system.h"
#include "solver/internal/trust_region/step_control.h"
#include "solver/summary.h"

namespace vesta {

enum class BatchMode {
  kExact,  // one PCG over the sum of all batches
  // One PCG per batch; the steps are averaged, weighted by diag(H) of their batches (3DGS-LM, eq. 7). The result is
  // biased, see solver/internal/batched_system.h.
  kMerge,
};
const char* ToString(BatchMode mode);

// Options of SolveLm and LmStepper. Validate checks the ranges.
struct LmOptions {
  // Stop after this many iterations, accepted or rejected; >= 0.
  int max_iterations = 50;
  // Stop when |change of cost| <= function_tolerance * cost.
  double function_tolerance = 1e-6;
  // Stop when max |x - (x (+) -g)| <= gradient_tolerance. x (+) d is the point that the step d leads to
  // (OnManifold::Plus).
  double gradient_tolerance = 1e-10;
  // Stop when |step| <= parameter_tolerance * (|x| + parameter_tolerance).
  double parameter_tolerance = 1e-8;
  // Stop after this many rejected iterations in a row.
  int max_consecutive_rejects = 50;
  // Wall-clock limit in seconds, checked before each iteration. No other decision depends on the clock.
  double max_seconds = std::numeric_limits<double>::infinity();

  // Set both by SetStepRule, because they must agree.
  StepRule step_rule = StepRule::kCeres;
  StepControlOptions step_control = DefaultStepControl(StepRule::kCeres);
  // Scale of each parameter, for the limits of the damping metric D and for the residual norm of PCG.
  ColumnScaling column_scaling = ColumnScaling::kInverseRoot;
  // The linear solver, its preconditioner and the damping metric.
  NormalSystemOptions normal_system;
  BatchMode batch_mode = BatchMode::kExact;
  // For kMerge: keep the linearizations of all batches in memory during a step. If false, a batch is linearized again
  // each time it is needed, so only one linearization is in memory.
  bool hold_batches = true;
  LineSearchOptions line_search;

  // Run CheckProblem at the start; a fault ends the solve as kCheckFailed. Use it while developing a problem. It takes
  // some hundred evaluations.
  bool check_derivatives = false;
  // Measure the time per phase (LmSummary::phases). Results do not change; on a GPU the solve is slower.
  bool profile = false;

  // Sets step_rule and the matching step_control.
  void SetStepRule(StepRule rule) {
    step_rule = rule;
    step_control = DefaultStepControl(rule);
  }
  // Throws Error with one line about the first option that is out of range.
  void Validate() const;
};

enum class CallbackResult { kContinue, kStop };
// Called after the start is evaluated (iteration 0) and after each iteration.
using LmCallback = std::function<CallbackResult(const LmIteration&)>;

}  // namespace vesta
