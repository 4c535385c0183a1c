#include "solver/trust_region/step_control.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"

namespace vesta {
namespace {

// Nielsen's factor after an accepted step.
double CubicFactor(double rho) { return std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * rho - 1.0, 3)); }

class GrowingRejects final : public StepControl {
 public:
  using StepControl::StepControl;

 protected:
  double AfterAccept(double rho) override {
    growth_ = 2.0;
    return lambda() * CubicFactor(rho);
  }
  double AfterReject() override {
    const double raised = lambda() * growth_;
    growth_ *= 2.0;
    return raised;
  }
};

class HalveOrDouble final : public StepControl {
 public:
  using StepControl::StepControl;

 protected:
  double AfterAccept(double) override { return 0.5 * lambda(); }
  double AfterReject() override { return 2.0 * lambda(); }
};

class CubicOrDouble final : public StepControl {
 public:
  using StepControl::StepControl;

 protected:
  double AfterAccept(double rho) override { return lambda() * CubicFactor(rho); }
  double AfterReject() override { return 2.0 * lambda(); }
};

class Soft final : public StepControl {
 public:
  using StepControl::StepControl;

 protected:
  double AfterAccept(double rho) override {
    return rho > 0.75 ? lambda() / 3.0 : rho < 0.25 ? 2.0 * lambda() : lambda();
  }
  double AfterReject() override { return 4.0 * lambda(); }
};

}  // namespace

const char* ToString(StepRule rule) {
  switch (rule) {
    case StepRule::kCeres:
      return "ceres";
    case StepRule::k3dgsLmCode:
      return "3dgs-lm code";
    case StepRule::k3dgsLmV1:
      return "3dgs-lm v1";
    case StepRule::k3dgsLmV2:
      return "3dgs-lm v2";
    case StepRule::kSoft:
      return "soft";
  }
  return "unknown";
}

void StepControlOptions::Validate() const {
  if (!(min_lambda > 0 && min_lambda <= initial_lambda && initial_lambda <= max_lambda && std::isfinite(max_lambda))) {
    Fail("step_control: lambda starts at {} within [{}, {}]; need 0 < min_lambda <= initial_lambda <= max_lambda",
         initial_lambda, min_lambda, max_lambda);
  }
  if (!(min_relative_decrease >= 0 && min_relative_decrease < 1)) {
    Fail("step_control.min_relative_decrease is {}; choose it within [0, 1)", min_relative_decrease);
  }
  if (!(lambda_after_first_reject >= 0 && lambda_after_first_reject <= max_lambda)) {
    Fail("step_control.lambda_after_first_reject is {}; choose it within [0, max_lambda]", lambda_after_first_reject);
  }
  for (const double gamma : backtracking) {
    if (!(gamma > 0 && gamma < 1)) Fail("step_control.backtracking has {}; choose fractions within (0, 1)", gamma);
  }
}

StepControlOptions DefaultStepControl(StepRule rule) {
  switch (rule) {
    case StepRule::kCeres:
      return {};
    case StepRule::k3dgsLmCode:
      return {.rule = rule, .initial_lambda = 1, .min_lambda = 1e-4, .max_lambda = 1e4, .min_relative_decrease = 0};
    case StepRule::k3dgsLmV1:
    case StepRule::k3dgsLmV2:
      return {.rule = rule, .initial_lambda = 1, .min_lambda = 1e-4, .max_lambda = 1e4, .min_relative_decrease = 1e-5};
    case StepRule::kSoft:
      return {.rule = rule, .initial_lambda = 1e-2, .min_relative_decrease = 0, .backtracking = {0.5, 0.2}};
  }
  return {};
}

StepControl::StepControl(const StepControlOptions& options) : options_(options), lambda_(options.initial_lambda) {
  options.Validate();
}

void StepControl::OnReject() {
  const bool first = lambda_ == options_.initial_lambda && options_.lambda_after_first_reject > lambda_;
  Set(first ? options_.lambda_after_first_reject : AfterReject());
}

void StepControl::Set(double lambda) { lambda_ = std::clamp(lambda, options_.min_lambda, options_.max_lambda); }

std::unique_ptr<StepControl> MakeStepControl(StepRule rule, const StepControlOptions& options) {
  switch (rule) {
    case StepRule::k3dgsLmV1:
      return std::make_unique<HalveOrDouble>(options);
    case StepRule::k3dgsLmV2:
      return std::make_unique<CubicOrDouble>(options);
    case StepRule::kSoft:
      return std::make_unique<Soft>(options);
    case StepRule::kCeres:
    case StepRule::k3dgsLmCode:
      break;
  }
  return std::make_unique<GrowingRejects>(options);
}

}  // namespace vesta
