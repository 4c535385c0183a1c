// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/lm_decisions.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vesta {

void LmTrial::DecideByGradient(bool finite, double squared_at_trial, double squared_at_x) {
  const double share = zone == Zone::kDoubtful ? 0.5 : 1.0;
  accepted = finite && squared_at_trial < share * squared_at_x;
  // Use a gain ratio of 1, because the true one is not measurable.
  if (accepted) rho = 1;
}

LmStatus LmVerdict::status() const {
  switch (reason) {
    case Reason::kNone:
      return LmStatus::kRunning;
    case Reason::kRoundingError:
    case Reason::kSmallChange:
      return doubt ? LmStatus::kNoDecrease : LmStatus::kFunctionTolerance;
    case Reason::kShortStep:
      return doubt ? LmStatus::kNoDecrease : LmStatus::kParameterTolerance;
    case Reason::kRejections:
    case Reason::kUpperBound:
      break;
  }
  return LmStatus::kNoDecrease;
}

LmDecisions::LmDecisions(const LmOptions& options, double rounding)
    : function_tolerance_(options.function_tolerance),
      parameter_tolerance_(options.parameter_tolerance),
      rounding_(rounding),
      max_consecutive_rejects_(options.max_consecutive_rejects),
      control_(options.step_control),
      nonmonotonic_(options.step_control.max_consecutive_nonmonotonic_steps) {}

double LmDecisions::DoubtfulGain() const {
  return std::max(std::max(10 * function_tolerance_, rounding_) * cost_, 1e-20 * initial_cost_);
}

LmTrial LmDecisions::Judge(double cost, double predicted) const {
  LmTrial trial{.cost = cost, .predicted = predicted, .change = cost_ - cost};
  // rho has the sign of the change of cost, whatever the model predicts.
  trial.rho = predicted == 0 && trial.change == 0 ? 0 : trial.change / std::abs(predicted);
  // A model that predicts no decrease cannot be trusted, even if the cost decreased.
  if (predicted > 0) trial.rho = nonmonotonic_.GainRatio(trial.rho, cost, predicted);
  trial.accepted = std::isfinite(cost) && predicted > 0 && control_.Accepts(trial.rho);
  trial.zone = ZoneOf(trial);
  return trial;
}

LmTrial::Zone LmDecisions::ZoneOf(const LmTrial& trial) const {
  using Zone = LmTrial::Zone;
  constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon(), kDoubt = 1e-9;
  const auto within = [&](double share) {
    return function_tolerance_ < share && trial.predicted <= share * cost_ && std::abs(trial.change) <= share * cost_;
  };
  // Never accept by gradient a cost above the start's. At bounds, only entries that are free to move count.
  if (!(trial.predicted > 0) || !(trial.cost <= initial_cost_)) return Zone::kCost;
  if (within(kRounding)) return Zone::kRounding;
  return within(kDoubt) && !trial.accepted ? Zone::kDoubtful : Zone::kCost;
}

LmVerdict LmDecisions::Finish(const LmTrial& trial, double step_norm, double x_norm, bool solved) {
  LmVerdict verdict;
  if (!trial.accepted && trial.zone == LmTrial::Zone::kRounding) {
    verdict = {.reason = LmVerdict::Reason::kRoundingError, .doubt = doubt_.Find(false, DoubtfulGain())};
  }
  if (trial.accepted) {
    control_.OnAccept(trial.rho);
    nonmonotonic_.OnAccept(trial.cost, trial.predicted);
    cost_ = trial.cost;
    consecutive_rejects_ = 0;
  } else {
    ++consecutive_rejects_;
  }
  if (!verdict.ends()) verdict = TestStep(trial, step_norm, x_norm, solved);
  if (!trial.accepted) {
    if (!verdict.ends() && control_.at_upper_bound()) {
      verdict = {.reason = LmVerdict::Reason::kUpperBound, .doubt = doubt_.Find(false, DoubtfulGain())};
    }
    control_.OnReject();
  }
  return verdict;
}

LmVerdict LmDecisions::TestStep(const LmTrial& trial, double step_norm, double x_norm, bool solved) {
  using Reason = LmVerdict::Reason;
  const double change = std::abs(trial.change);
  const double before = trial.accepted ? cost_ + trial.change : cost_;
  const bool by_gradient = trial.accepted && trial.zone != LmTrial::Zone::kCost;
  const double smallest = parameter_tolerance_ * (x_norm + parameter_tolerance_);
  // Doubt from the steps before this one, then including this one.
  const Doubt doubt_before = doubt_.Find(trial.accepted, DoubtfulGain());
  if (!trial.accepted) {
    const double predicted = trial.is_clipped ? std::max(trial.predicted, 0.0) : trial.predicted;
    doubt_.OnReject(predicted, std::isfinite(trial.cost));
  }
  const Doubt doubt = doubt_.Find(trial.accepted, DoubtfulGain());
  if (trial.accepted) doubt_.OnAccept();
  if (solved && step_norm <= smallest) return {Reason::kShortStep, step_norm, smallest, doubt_before};
  if (solved && !by_gradient && change <= function_tolerance_ * before) {
    return {Reason::kSmallChange, before > 0 ? change / before : 0.0, function_tolerance_, doubt};
  }
  if (consecutive_rejects_ >= max_consecutive_rejects_) {
    return {Reason::kRejections, static_cast<double>(consecutive_rejects_), 0, doubt};
  }
  return {};
}

}  // namespace vesta
