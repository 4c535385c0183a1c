// How the damping lambda follows the gain ratio rho = (decrease of the cost) / (decrease the model predicted).
#pragma once

#include <memory>
#include <vector>

namespace vesta {

enum class StepRule {
  // lambda times max(1/3, 1 - (2 rho - 1)^3), or times nu = 2, 4, 8, ... on rejects (Nielsen, Damping parameter in
  // Marquardt's method, 1999). Ceres's trust-region radius is 1/lambda under this rule. These two differ in where
  // they start, what they accept and their bounds.
  kCeres,       // lambda starts at 1e-4 (radius 1e4), accepts rho > 1e-3
  k3dgsLmCode,  // 3DGS-LM as released: starts at 1, accepts rho > 0, lambda within [1e-4, 1e4]
  // 3DGS-LM as first printed (arXiv v1): halved, or doubled on rejects; accepts rho > 1e-5; [1e-4, 1e4].
  k3dgsLmV1,
  // As in the later print: times max(1/3, 1 - (2 rho - 1)^3), or doubled; accepts rho > 1e-5; [1e-4, 1e4].
  k3dgsLmV2,
  // rho > 3/4: divided by 3; rho < 1/4: doubled; rejects: times 4, after shorter steps along the same direction were
  // tried. No spiral on costs with small jumps. Starts at 1e-2, accepts rho > 0.
  kSoft,
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
  // Fractions of a rejected step, within (0, 1), tried in this order before lambda is raised and the system solved
  // again. Empty: none.
  std::vector<double> backtracking = {};
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
  virtual ~StepControl() = default;
  StepControl(const StepControl&) = delete;
  StepControl& operator=(const StepControl&) = delete;

  double lambda() const { return lambda_; }
  // Whether a further reject would leave lambda where it is.
  bool at_upper_bound() const { return lambda_ >= options_.max_lambda; }
  // false for NaN.
  bool Accepts(double rho) const { return rho > options_.min_relative_decrease; }
  void OnAccept(double rho) { Set(AfterAccept(rho)); }
  // The full step failed, a shorter one along it was accepted: lambda was too small.
  void OnShortenedAccept() { Set(2.0 * lambda_); }
  void OnReject();

  // All that the next answers depend on, beside the options.
  template <class Archive>
  void Visit(Archive& archive) {
    archive(lambda_, growth_);
    if constexpr (Archive::kReads) Set(lambda_);
  }

 protected:
  virtual double AfterAccept(double rho) = 0;
  virtual double AfterReject() = 0;

  double growth_ = 2;  // of lambda at the next reject, where it grows with each

 private:
  void Set(double lambda);

  StepControlOptions options_;
  double lambda_;
};

std::unique_ptr<StepControl> MakeStepControl(StepRule rule, const StepControlOptions& options);

}  // namespace vesta
