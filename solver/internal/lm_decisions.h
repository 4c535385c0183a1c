// SPDX-License-Identifier: Apache-2.0
// The decisions of the Levenberg-Marquardt method: whether a trial point is accepted, the next damping, and when the
// solve ends. LmStepper and SmallSolver share them.
#pragma once

#include "solver/internal/trust_region/nonmonotonic.h"
#include "solver/internal/trust_region/step_control.h"
#include "solver/lm_options.h"
#include "solver/summary.h"

namespace vesta {

// A trial point along the step, and whether it is accepted. Normally the gain ratio (decrease of the cost divided by
// the predicted decrease) decides. Near the minimum, a step changes the cost by less than the cost's rounding error, so
// the gain ratio is random. The gradient g is still accurate there, so the change of its norm decides instead. This
// gives x about twice as many correct digits. |g|^2 is sum_k g_k^2 / D_k. The rounding error of the cost depends on the
// problem: it is large if residuals are small differences of large numbers. Therefore there are two zones that use the
// gradient.
struct LmTrial {
  enum class Zone {
    kCost,      // the gain ratio decides
    kDoubtful,  // |change of cost| <= 1e-9 cost, and the gain ratio rejects the point: accepted if |g|^2 halves
    kRounding,  // the cost changes by its last few bits only: accepted if |g| decreases, else the solve ends
  };
  double cost = 0;
  double predicted = 0;  // predicted decrease of the cost
  double change = 0;     // decrease of the cost
  double rho = 0;        // gain ratio
  bool accepted = false;
  // Bounds have shortened entries of the step. The model may then predict an increase, although J and J^T are right.
  bool is_clipped = false;
  Zone zone = Zone::kCost;

  // Decides in the zones that use the gradient. finite: whether the derivatives at the trial point are finite. The
  // squared norms |g|^2 are those at the trial point and at x, both with the D of x.
  void DecideByGradient(bool finite, double squared_at_trial, double squared_at_x);
};

// Whether a solve ends after a trial, and why.
struct LmVerdict {
  enum class Reason {
    kNone,           // the solve continues
    kRoundingError,  // cost and gradient have reached their rounding error
    kShortStep,      // value: the length of the step; limit: the largest one that counts as short
    kSmallChange,    // value: |change of cost| / cost; limit: the tolerance
    kRejections,     // too many rejected steps in a row; value: their number
    kUpperBound,     // a step was rejected with lambda at its upper bound
  };
  Reason reason = Reason::kNone;
  double value = 0, limit = 0;
  Doubt doubt = {};

  bool ends() const { return reason != Reason::kNone; }
  // The status of a solve that ends for this reason; kRunning if it continues.
  LmStatus status() const;
};

// The state that the decisions of one solve depend on. Costs are variable costs (WithFixedCost).
class LmDecisions {
 public:
  // rounding: relative change of the cost that may be a rounding error (CostRounding). Throws Error if the options for
  // lambda are out of range.
  LmDecisions(const LmOptions& options, double rounding);

  // start_cost: the cost at the start.
  void Start(double start_cost) {
    SetCosts(start_cost, start_cost);
    nonmonotonic_.Start(start_cost);
  }
  void SetCosts(double initial_cost, double cost) { initial_cost_ = initial_cost, cost_ = cost; }
  double initial_cost() const { return initial_cost_; }
  // The cost at the current point.
  double cost() const { return cost_; }
  double lambda() const { return control_.lambda(); }
  // Whether steps may raise the cost (StepControlOptions::max_consecutive_nonmonotonic_steps).
  bool is_nonmonotonic() const { return nonmonotonic_.enabled(); }
  // The lowest cost of all points so far, if is_nonmonotonic(), and whether the current point has it.
  double lowest_cost() const { return nonmonotonic_.lowest(); }
  bool at_lowest_cost() const { return !is_nonmonotonic() || cost_ <= nonmonotonic_.lowest(); }

  // Judges a trial point by its cost. If its zone is not kCost, call DecideByGradient next.
  LmTrial Judge(double cost, double predicted) const;
  // Takes or rejects the trial: updates the cost and lambda, and tests whether the solve ends. x_norm: norm of the
  // point before the step. solved: false if the linear solver failed before its first iteration. Such a failure says
  // nothing about x.
  LmVerdict Finish(const LmTrial& trial, double step_norm, double x_norm, bool solved);
  // The doubt of a solve that ends at its limit of iterations.
  Doubt AtLimit() const { return doubt_.FindIncrease(DoubtfulGain()); }

  // Saves or loads the state, without options and costs.
  template <class Archive>
  void Visit(Archive& archive) {
    archive(control_, consecutive_rejects_, doubt_);
    if (is_nonmonotonic()) archive(nonmonotonic_);
  }

 private:
  LmTrial::Zone ZoneOf(const LmTrial& trial) const;
  LmVerdict TestStep(const LmTrial& trial, double step_norm, double x_norm, bool solved);
  // ConvergenceDoubt ignores predicted changes of the cost up to this value. Such changes are below the function
  // tolerance, or may be rounding errors.
  double DoubtfulGain() const;

  double function_tolerance_, parameter_tolerance_, rounding_;
  int max_consecutive_rejects_;
  StepControl control_;
  NonmonotonicReference nonmonotonic_;
  double initial_cost_ = 0, cost_ = 0;
  int consecutive_rejects_ = 0;
  ConvergenceDoubt doubt_;
};

// Relative changes of a cost up to this value may be rounding errors of residuals of type S.
template <class S>
constexpr double CostRounding() {
  return sizeof(S) == sizeof(double) ? 1e-9 : 1e-4;
}

}  // namespace vesta
