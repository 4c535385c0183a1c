// SPDX-License-Identifier: Apache-2.0
// Options of the Levenberg-Marquardt solver.
#pragma once

#include <functional>
#include <limits>
#include <type_traits>
#include <utility>

#include "solver/internal/normal_equations/normal_system.h"
#include "solver/internal/trust_region/step_control.h"
#include "solver/summary.h"

namespace vesta {

enum class BatchMode {
  // One linear solve for the sum of all batches. The result is the same as with a single batch.
  kExact,
  // One linear solve per batch. The steps are averaged, weighted by diag(H) of their batches (3DGS-LM, eq. 7). The
  // solution is biased: it is not exactly the minimum of the cost (solver/internal/batched_system.h).
  kMerge,
};
const char* ToString(BatchMode mode);

// Options of SolveLm and LmStepper. g is the gradient of the cost, H its Gauss-Newton Hessian, and D the damping metric
// in (H + lambda D) step = -g.
struct LmOptions {
  // Stop after this many iterations, accepted or rejected; >= 0.
  int max_iterations = 50;
  // Stop when |change of cost| <= function_tolerance * cost, where cost is the value before the step, without the fixed
  // cost (WithFixedCost).
  double function_tolerance = 1e-6;
  // Stop when max |x - (x (+) -g)| <= gradient_tolerance. x (+) d is the point that the step d leads to from x
  // (OnManifold::Plus); without a manifold or bounds the test is max |g|.
  double gradient_tolerance = 1e-10;
  // Stop when |step| <= parameter_tolerance * (|x| + parameter_tolerance). |x| is the norm of the variable entries of x
  // (WithFixedCost).
  double parameter_tolerance = 1e-8;
  // Stop after this many rejected iterations in a row.
  int max_consecutive_rejects = 50;
  // Wall-clock limit in seconds, >= 0, checked before each iteration. No other decision depends on the clock.
  double max_seconds = std::numeric_limits<double>::infinity();

  // Rule for changing lambda, and its parameters. Use SetStepRule, which sets both consistently.
  StepRule step_rule = StepRule::kCeres;
  StepControlOptions step_control = DefaultStepControl(StepRule::kCeres);
  // Scale of each parameter. It sets the units of the limits on D, and of the residual norm of PCG.
  ColumnScaling column_scaling = ColumnScaling::kInverseRoot;
  // The linear solver, its preconditioner and the damping metric.
  NormalSystemOptions normal_system;
  BatchMode batch_mode = BatchMode::kExact;
  // For kMerge: store the linearizations of all batches during an iteration. If false, each batch is linearized again
  // when it is needed, so only one linearization is in memory at a time.
  bool hold_batches = true;
  LineSearchOptions line_search;

  // Run CheckProblem at the start; a fault ends the solve as kCheckFailed. Use this while developing a problem. It
  // evaluates each function of the problem about 100 times.
  bool check_derivatives = false;
  // Measure the time of each phase of the solve (LmSummary::phases). The computed values stay the same; on a GPU the
  // solve is slower.
  bool profile = false;

  // Sets step_rule and the matching step_control.
  void SetStepRule(StepRule rule) {
    step_rule = rule;
    step_control = DefaultStepControl(rule);
  }
  // Throws Error if an option is out of range. The message names the first such option.
  void Validate() const;
};

enum class CallbackResult { kContinue, kStop };
// Called after the start is evaluated (iteration 0) and after each iteration.
using LmCallback = std::function<CallbackResult(const LmIteration&)>;
// The callback argument of SolveLm: an LmCallback, or a function (const LmIteration&, B::ConstVectorView x) whose x is
// the best point so far (LmStepper::x).
template <Backend B>
class IterationCallback {
 public:
  using X = typename B::ConstVectorView;
  IterationCallback() = default;
  template <class F>
  requires std::is_invocable_r_v<CallbackResult, const F&, const LmIteration&, X> IterationCallback(F callback)
      : callback_(std::move(callback)) {}
  template <class F>
  requires std::is_invocable_r_v<CallbackResult, const F&, const LmIteration&> IterationCallback(F callback) {
    if constexpr (std::is_same_v<F, LmCallback> || std::is_pointer_v<F>) {
      if (!static_cast<bool>(callback)) return;
    }
    callback_ = [callback = std::move(callback)](const LmIteration& row, X) { return callback(row); };
  }
  // kContinue if there is no function.
  CallbackResult operator()(const LmIteration& row, X x) const {
    return callback_ ? callback_(row, x) : CallbackResult::kContinue;
  }

 private:
  std::function<CallbackResult(const LmIteration&, X)> callback_;
};

}  // namespace vesta
