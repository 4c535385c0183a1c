// SPDX-License-Identifier: Apache-2.0
// Controls the damping lambda by the gain ratio rho = (decrease of the cost) / (predicted decrease). Also detects steps
// that contradict convergence, and chooses the factor along a step.
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
  // A rejected step multiplies lambda by nu = 2, 4, 8, ... (Nielsen, Damping parameter in Marquardt's method, 1999).
  // With kCeres, 1/lambda is Ceres's trust-region radius. kCeres and k3dgsLmCode differ in the initial lambda, the
  // acceptance threshold and the bounds.
  kCeres,       // initial lambda 1e-4 (radius 1e4), accepts rho > 1e-3
  k3dgsLmCode,  // 3DGS-LM as released: initial lambda 1, accepts rho > 0, lambda within [1e-4, 1e4]
  k3dgsLmV2,    // 3DGS-LM as published: a rejected step doubles lambda; initial lambda 1, accepts rho > 1e-5, lambda
                // within [1e-4, 1e4]
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
  // Value of lambda after the very first step is rejected, if it is larger than initial_lambda. Such a rejection shows
  // that the start is far from the minimum, so a small initial_lambda was wrong. 0: no special rule.
  double lambda_after_first_reject = 0;

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
  // False if rho is NaN.
  bool Accepts(double rho) const { return rho > options_.min_relative_decrease; }
  void OnAccept(double rho);
  void OnReject();

  // Saves or loads the state, without the options.
  template <class Archive>
  void Visit(Archive& archive) {
    archive(lambda_, growth_);
    if constexpr (Archive::kReads) Set(lambda_);
  }

 private:
  void Set(double lambda);

  StepControlOptions options_;
  double lambda_;
  double growth_ = 2;  // factor for lambda at the next rejected step
};

// Collects evidence against convergence from rejected steps. A short step with little change does not show convergence
// if a longer one was rejected despite a large predicted decrease.
class StepDoubt {
 public:
  // predicted: decrease of the cost by the model. finite: true if the cost of the trial is finite.
  void OnReject(double predicted, bool finite);
  void OnAccept() { *this = {}; }

  // Returns a suspected mistake of the problem, starting with "; ", from the steps rejected since the last accepted
  // one, or an empty string. Predicted changes up to `least` are ignored, because they may be rounding.
  // accepted: true if a step was accepted now; then only steps to points where the cost is not finite count.
  std::string Words(bool accepted, double least) const;
  // The part of Words about predicted increases, which are always a mistake.
  std::string IncreaseWords(double least) const;

  template <class Archive>
  void Visit(Archive& archive) {
    archive(promised_, blocked_, increase_);
  }

 private:
  double promised_ = 0;  // largest predicted decrease
  double blocked_ = 0;   // largest predicted decrease of a trial without a finite cost
  double increase_ = 0;  // largest predicted increase
};

// Chooses a factor gamma <= 1 along each step, by the cost of a subset of the units (3DGS-LM's line search). gamma
// starts at 1 and is multiplied by `shrink` until the cost rises; the last value before that is used.
struct LineSearchOptions {
  bool enabled = false;
  // Fraction of the problem's units in the subset, within (0, 1]; at least one unit.
  double unit_fraction = 0.3;
  // Within (0, 1).
  double shrink = 0.7;
  int max_evaluations = 12;

  void Validate() const;
};

// Returns about fraction * num_units units (at least one), evenly spread, ascending. `turn` shifts the pattern, so that
// successive steps use different units.
std::vector<Index> SpreadUnits(Index num_units, double fraction, Index turn);

struct LineSearchResult {
  double gamma = 1;
  int evaluations = 0;
};

// Searches gamma as LineSearchOptions describes. A cost that is not finite counts as infinite.
LineSearchResult SearchGamma(const LineSearchOptions& options, const std::function<double(double)>& subset_cost);

}  // namespace vesta
