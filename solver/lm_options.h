// SPDX-License-Identifier: Apache-2.0
// Options of Levenberg-Marquardt.
#pragma once

#include <functional>
#include <limits>

#include "solver/internal/normal_equations/normal_system.h"
#include "solver/internal/trust_region/step_control.h"
#include "solver/summary.h"

namespace vesta {

enum class BatchMode {
  kExact,  // one PCG over the sum of all batches
  kMerge,  // each batch solved on its own, the steps merged by their diagonals (3DGS-LM, eq. 7): biased, see
           // solver/internal/batched_system.h
};
const char* ToString(BatchMode mode);

struct LmOptions {
  int max_iterations = 50;
  // Stop when |change of cost| <= function_tolerance * cost.
  double function_tolerance = 1e-6;
  // Stop when max |x - (x (+) -g)| <= gradient_tolerance.
  double gradient_tolerance = 1e-10;
  // Stop when |step| <= parameter_tolerance * (|x| + parameter_tolerance).
  double parameter_tolerance = 1e-8;
  // Stop after so many rejected iterations in a row.
  int max_consecutive_rejects = 50;
  // Wall-clock limit, checked before each iteration: the one decision that reads the clock.
  double max_seconds = std::numeric_limits<double>::infinity();

  // Set by SetStepRule, for the two go together.
  StepRule step_rule = StepRule::kCeres;
  StepControlOptions step_control = DefaultStepControl(StepRule::kCeres);
  ColumnScaling column_scaling = ColumnScaling::kInverseRoot;
  NormalSystemOptions normal_system;
  BatchMode batch_mode = BatchMode::kExact;
  // kMerge: keep the linearizations of all batches alive through a step. false makes them anew each time one is
  // needed, so that the caches of one batch at a time are held.
  bool hold_batches = true;
  LineSearchOptions line_search;

  // CheckProblem at the start: a fault ends the solve, as kCheckFailed. For while a problem is written; it takes some
  // hundred evaluations.
  bool check_derivatives = false;
  // Times the phases of the solve (LmSummary::phases). Changes no result; on a GPU it costs time.
  bool profile = false;

  // Sets step_rule and the step_control that belongs to it.
  void SetStepRule(StepRule rule) {
    step_rule = rule;
    step_control = DefaultStepControl(rule);
  }
  // Throws Error with one line on the first option out of its range.
  void Validate() const;
};

enum class CallbackResult { kContinue, kStop };
// Called after the evaluation of the start (iteration 0) and after each iteration.
using LmCallback = std::function<CallbackResult(const LmIteration&)>;

}  // namespace vesta
