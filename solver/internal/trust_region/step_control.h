// SPDX-License-Identifier: Apache-2.0
// StepControl changes the damping lambda by the gain ratio rho = (decrease of the cost) / (predicted decrease).
// ConvergenceDoubt detects rejected steps that contradict convergence. SearchGamma is the line search.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kernels/core/span.h"

namespace vesta {

// All rules multiply lambda by max(1/3, 1 - (2 rho - 1)^3) after an accepted step.
enum class StepRule {
  // With kCeres and k3dgsLmCode, successive rejected steps multiply lambda by 2, 4, 8, ... (Nielsen, Damping parameter
  // in Marquardt's method, 1999). These two rules differ in the initial lambda, in the bounds, and in the value that
  // rho must exceed. 1/lambda corresponds to Ceres's trust-region radius.
  kCeres,       // initial lambda 1e-4 (radius 1e4), accepts rho > 1e-3
  k3dgsLmCode,  // 3DGS-LM as released: initial lambda 1, accepts rho > 0, lambda within [1e-4, 1e4]
  // 3DGS-LM as published: every rejected step doubles lambda. The initial lambda is 1, rho > 1e-5 is accepted, and
  // lambda stays within [1e-4, 1e4].
  k3dgsLmV2,
};
const char* ToString(StepRule rule);

struct StepControlOptions {
  // The rule that these values belong to. Set by DefaultStepControl.
  StepRule rule = StepRule::kCeres;
  double initial_lambda = 1e-4;
  // 0 < min_lambda <= initial_lambda <= max_lambda.
  double min_lambda = 1e-16;
  double max_lambda = 1e32;
  // A step is accepted if rho exceeds this; within [0, 1).
  double min_relative_decrease = 1e-3;
  // If the first step is rejected, lambda is set to this value, provided that it is larger than initial_lambda. Such a
  // rejection shows that the start is far from the minimum, so that a small initial_lambda was wrong. 0: treat the
  // first step like the others.
  double lambda_after_first_reject = 0;
  // If > 0, accept steps that raise the cost, if the cost has decreased enough since an earlier point. That point
  // changes after this number of successive accepted steps without a new lowest cost (NonmonotonicReference); >= 0. 0:
  // each step must decrease the cost. Ceres uses 5 with use_nonmonotonic_steps.
  int max_consecutive_nonmonotonic_steps = 0;

  void Validate() const;
};

// Returns the default values of a rule.
StepControlOptions DefaultStepControl(StepRule rule);

class StepControl {
 public:
  explicit StepControl(const StepControlOptions& options);

  double lambda() const { return lambda_; }
  // True if another rejected step would leave lambda unchanged.
  bool at_upper_bound() const { return lambda_ >= options_.max_lambda; }
  // True if a step with this gain ratio is accepted; false if rho is NaN.
  bool Accepts(double rho) const { return rho > options_.min_relative_decrease; }
  // Updates lambda after an accepted or a rejected step.
  void OnAccept(double rho);
  void OnReject();

  // Saves or loads the state, without the options.
  template <class Archive>
  void Visit(Archive& archive) {
    archive(lambda_, growth_);
    if constexpr (Archive::kReads) Set(lambda_);
  }

 private:
  // Sets lambda, clamped to its bounds.
  void Set(double lambda);

  StepControlOptions options_;
  double lambda_;
  double growth_ = 0;  // factor for lambda at the next rejected step; 0 before the first step
};

// A reason to doubt convergence, which suggests a mistake in the problem.
struct Doubt {
  enum class Kind {
    kNone,
    kNonFinite,  // a step that should decrease the cost leads to a point where the cost is not finite
    kIncrease,   // the model predicts an increase
    kDecrease,   // a step that should decrease the cost was rejected
  };
  Kind kind = Kind::kNone;
  double predicted = 0;  // predicted decrease of this step

  explicit operator bool() const { return kind != Kind::kNone; }
  // A description that starts with "; ", or an empty string for kNone.
  std::string Describe() const;
};

// Detects false convergence, which wrong derivatives can cause. A short step that hardly changes the cost is no
// evidence of convergence if a longer step was rejected although the model predicted a large decrease. This class
// records the rejected steps since the last accepted one.
class ConvergenceDoubt {
 public:
  // predicted: predicted decrease of the cost. finite: true if the cost of the trial point is finite.
  void OnReject(double predicted, bool finite);
  void OnAccept() { *this = {}; }

  // Predicted changes up to `least` are ignored, because they may be rounding errors. accepted: true if the current
  // step was accepted; then only rejected steps to points where the cost is not finite are considered.
  Doubt Find(bool accepted, double least) const;
  // The same, only for predicted increases of the cost. They are always a mistake.
  Doubt FindIncrease(double least) const;

  template <class Archive>
  void Visit(Archive& archive) {
    archive(decrease_, decrease_non_finite_, increase_);
  }

 private:
  double decrease_ = 0;             // largest predicted decrease
  double decrease_non_finite_ = 0;  // largest predicted decrease of a trial point whose cost is not finite
  double increase_ = 0;             // largest predicted increase
};

// Line search of 3DGS-LM. It chooses a factor gamma <= 1 for each step, by the cost of a subset of the units (InUnits).
// gamma starts at 1 and is multiplied by `shrink` repeatedly, until the cost no longer decreases. The last value before
// that is used.
struct LineSearchOptions {
  bool enabled = false;
  // Fraction of the problem's units in the subset, within (0, 1]; at least one unit.
  double unit_fraction = 0.3;
  // Within (0, 1).
  double shrink = 0.7;
  // Limit on the evaluations of the cost per step; >= 2.
  int max_evaluations = 12;

  void Validate() const;
};

// Returns the indices of about fraction * num_units units (at least one), evenly spread, in ascending order. `turn`
// (the number of the step) shifts the indices, so that successive steps use different units.
std::vector<Index> SpreadUnits(Index num_units, double fraction, Index turn);

struct LineSearchResult {
  double gamma = 1;
  int evaluations = 0;  // of subset_cost
};

// Searches gamma as described for LineSearchOptions. subset_cost(gamma): cost of the subset of the units. A cost that
// is not finite counts as infinity.
LineSearchResult SearchGamma(const LineSearchOptions& options, const std::function<double(double)>& subset_cost);

}  // namespace vesta
