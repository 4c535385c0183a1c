// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/trust_region/step_control.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/core/check.h"

namespace vesta {
namespace {

// Nielsen's factor after an accepted step.
double CubicFactor(double rho) {
  const double x = 2.0 * rho - 1.0;
  if (x > 0.874) return 1.0 / 3.0;  // x^3 > 2/3; pow takes a notable part of the time of a small solve
  return std::max(1.0 / 3.0, 1.0 - std::pow(x, 3));
}

}  // namespace

const char* ToString(StepRule rule) {
  switch (rule) {
    case StepRule::kCeres:
      return "ceres";
    case StepRule::k3dgsLmCode:
      return "3dgs-lm code";
    case StepRule::k3dgsLmV2:
      return "3dgs-lm v2";
  }
  return "unknown";
}

void StepControlOptions::Validate() const {
  if (!(min_lambda > 0 && min_lambda <= initial_lambda && initial_lambda <= max_lambda && std::isfinite(max_lambda))) {
    Fail(kBadArgument,
         "step_control: lambda starts at {} within [{}, {}]; need 0 < min_lambda <= initial_lambda <= max_lambda",
         initial_lambda, min_lambda, max_lambda);
  }
  if (!(min_relative_decrease >= 0 && min_relative_decrease < 1)) {
    Fail(kBadArgument, "step_control.min_relative_decrease is {}; choose it within [0, 1)", min_relative_decrease);
  }
  if (!(lambda_after_first_reject >= 0 && lambda_after_first_reject <= max_lambda)) {
    Fail(kBadArgument, "step_control.lambda_after_first_reject is {}; choose it within [0, max_lambda]",
         lambda_after_first_reject);
  }
  if (max_consecutive_nonmonotonic_steps < 0) {
    Fail(kBadArgument, "step_control.max_consecutive_nonmonotonic_steps is {}; choose 0 or more",
         max_consecutive_nonmonotonic_steps);
  }
}

StepControlOptions DefaultStepControl(StepRule rule) {
  switch (rule) {
    case StepRule::kCeres:
      return {};
    case StepRule::k3dgsLmCode:
      return {.rule = rule, .initial_lambda = 1, .min_lambda = 1e-4, .max_lambda = 1e4, .min_relative_decrease = 0};
    case StepRule::k3dgsLmV2:
      return {.rule = rule, .initial_lambda = 1, .min_lambda = 1e-4, .max_lambda = 1e4, .min_relative_decrease = 1e-5};
  }
  return {};
}

StepControl::StepControl(const StepControlOptions& options) : options_(options), lambda_(options.initial_lambda) {
  options.Validate();
}

void StepControl::OnAccept(double rho) {
  growth_ = 2;
  Set(lambda_ * CubicFactor(rho));
}

void StepControl::OnReject() {
  const bool first = growth_ == 0;
  if (first) growth_ = 2;
  if (first && options_.lambda_after_first_reject > lambda_) {
    Set(options_.lambda_after_first_reject);
    return;
  }
  Set(lambda_ * growth_);
  if (options_.rule != StepRule::k3dgsLmV2) growth_ *= 2;
}

void StepControl::Set(double lambda) { lambda_ = std::clamp(lambda, options_.min_lambda, options_.max_lambda); }

void ConvergenceDoubt::OnReject(double predicted, bool finite) {
  decrease_ = std::max(decrease_, predicted);
  increase_ = std::max(increase_, -predicted);
  if (!finite) decrease_non_finite_ = std::max(decrease_non_finite_, predicted);
}

Doubt ConvergenceDoubt::Find(bool accepted, double least) const {
  if (decrease_non_finite_ > least) return {Doubt::Kind::kNonFinite, decrease_non_finite_};
  if (accepted) return {};
  if (const Doubt increase = FindIncrease(least)) return increase;
  if (decrease_ > least) return {Doubt::Kind::kDecrease, decrease_};
  return {};
}

Doubt ConvergenceDoubt::FindIncrease(double least) const {
  if (increase_ <= least) return {};
  return {Doubt::Kind::kIncrease, -increase_};
}

std::string Doubt::Describe() const {
  switch (kind) {
    case Kind::kNone:
      break;
    case Kind::kNonFinite:
      return fmt::format("; a step with predicted decrease {:.3e} leads to a point where the cost is not finite",
                         predicted);
    case Kind::kIncrease:
      return "; the model predicts an increase: are J and J^T adjoint? Call CheckProblem";
    case Kind::kDecrease:
      return fmt::format(
          "; a step with predicted decrease {:.3e} was rejected: are the derivatives right? Call CheckProblem",
          predicted);
  }
  return "";
}

std::vector<Index> SpreadUnits(Index num_units, double fraction, Index turn) {
  const Index count = std::clamp<Index>(std::llround(fraction * static_cast<double>(num_units)), 1, num_units);
  std::vector<Index> units;
  for (Index k = 0; k < count; ++k) units.push_back((k * num_units / count + turn) % num_units);
  std::sort(units.begin(), units.end());
  return units;
}

void LineSearchOptions::Validate() const {
  if (!(unit_fraction > 0 && unit_fraction <= 1)) {
    Fail(kBadArgument, "line_search.unit_fraction is {}; choose it within (0, 1]", unit_fraction);
  }
  if (!(shrink > 0 && shrink < 1)) Fail(kBadArgument, "line_search.shrink is {}; choose it within (0, 1)", shrink);
  if (max_evaluations < 2) Fail(kBadArgument, "line_search.max_evaluations is {}; choose 2 or more", max_evaluations);
}

LineSearchResult SearchGamma(const LineSearchOptions& options, const std::function<double(double)>& subset_cost) {
  const auto cost_at = [&](double gamma) {
    const double cost = subset_cost(gamma);
    return std::isfinite(cost) ? cost : std::numeric_limits<double>::infinity();
  };
  LineSearchResult best;
  double lowest = cost_at(best.gamma);
  best.evaluations = 1;
  for (double gamma = options.shrink; best.evaluations < options.max_evaluations; gamma *= options.shrink) {
    const double cost = cost_at(gamma);
    ++best.evaluations;
    if (std::isfinite(lowest) && cost >= lowest) break;
    lowest = cost;
    best.gamma = gamma;
  }
  return best;
}

}  // namespace vesta
