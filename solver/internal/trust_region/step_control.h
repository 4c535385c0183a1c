// SPDX-License-Identifier: Apache-2.0
// How the damping lambda follows the gain ratio rho = (decrease of the cost) / (decrease the model predicted), when a
// gain is within rounding, and the factor along a step.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kernels/core/span.h"

namespace vesta {

// All multiply lambda by max(1/3, 1 - (2 rho - 1)^3) where a step is accepted.
enum class StepRule {
  // Rejects multiply lambda by nu = 2, 4, 8, ... (Nielsen, Damping parameter in Marquardt's method, 1999). Ceres's
  // trust-region radius is 1/lambda under this rule. These two differ in where they start, what they accept and their
  // bounds.
  kCeres,       // lambda starts at 1e-4 (radius 1e4), accepts rho > 1e-3
  k3dgsLmCode,  // 3DGS-LM as released: starts at 1, accepts rho > 0, lambda within [1e-4, 1e4]
  k3dgsLmV2,    // 3DGS-LM as printed: rejects double lambda; starts at 1, accepts rho > 1e-5, lambda within [1e-4, 1e4]
};
const char* ToString(StepRule rule);

struct StepControlOptions {
  // The rule that the values below belong to. DefaultStepControl sets it.
  StepRule rule = StepRule::kCeres;
  double initial_lambda = 1e-4;
  // 0 < min_lambda <= initial_lambda <= max_lambda.
  double min_lambda = 1e-16;
  double max_lambda = 1e32;
  // Steps are accepted when rho exceeds this; within [0, 1).
  double min_relative_decrease = 1e-3;
  // Where lambda goes when the very first step is refused, if that is above initial_lambda: then the start is far from
  // the minimum, and an initial_lambda for starts near it was a mistake. 0: it is raised as after any other.
  double lambda_after_first_reject = 0;

  void Validate() const;
};

// The values that belong to a rule.
StepControlOptions DefaultStepControl(StepRule rule);

class StepControl {
 public:
  explicit StepControl(const StepControlOptions& options);

  double lambda() const { return lambda_; }
  // Whether a further reject would leave lambda where it is.
  bool at_upper_bound() const { return lambda_ >= options_.max_lambda; }
  // false for NaN.
  bool Accepts(double rho) const { return rho > options_.min_relative_decrease; }
  void OnAccept(double rho);
  void OnReject();

  // All that the next answers depend on, beside the options.
  template <class Archive>
  void Visit(Archive& archive) {
    archive(lambda_, growth_);
    if constexpr (Archive::kReads) Set(lambda_);
  }

 private:
  void Set(double lambda);

  StepControlOptions options_;
  double lambda_;
  double growth_ = 2;  // of lambda at the next reject
};

// What rejected steps say against convergence: after a step that was to gain much and did not, a shorter one that
// changes little says nothing of x.
class StepDoubt {
 public:
  // predicted: decrease of the cost by the model. finite: whether the cost of the trial was.
  void OnReject(double predicted, bool finite);
  void OnAccept() { *this = {}; }

  // What to suspect of the problem, beginning with "; ", of the steps rejected since the last accepted one; empty:
  // nothing. Decreases and increases up to `least` do not count: they may be rounding. accepted: for a step that was
  // accepted now, against which only steps to where the cost is not finite speak.
  std::string Words(bool accepted, double least) const;
  // The part of it that no step excuses.
  std::string IncreaseWords(double least) const;

  template <class Archive>
  void Visit(Archive& archive) {
    archive(promised_, blocked_, increase_);
  }

 private:
  double promised_ = 0;  // the largest decrease predicted
  double blocked_ = 0;   // of a trial without a finite cost
  double increase_ = 0;  // the largest increase predicted
};

// Chooses a factor gamma <= 1 along each step by the cost over a subset of the units: from 1 down by `shrink` until the
// cost rises, then back by one (3DGS-LM's search).
struct LineSearchOptions {
  bool enabled = false;
  // Share of the problem's units in the subset, within (0, 1]; at least one unit.
  double unit_fraction = 0.3;
  // Within (0, 1).
  double shrink = 0.7;
  int max_evaluations = 12;

  void Validate() const;
};

// About fraction * num_units units (at least one), evenly spread, ascending; `turn` moves the pattern along, so that
// successive steps look at different units.
std::vector<Index> SpreadUnits(Index num_units, double fraction, Index turn);

struct LineSearchResult {
  double gamma = 1;
  int evaluations = 0;
};

// From gamma = 1 down by options.shrink until subset_cost(gamma) first rises, then back by one. A cost that is not
// finite counts as infinitely high.
LineSearchResult SearchGamma(const LineSearchOptions& options, const std::function<double(double)>& subset_cost);

}  // namespace vesta
