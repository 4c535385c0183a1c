#include "solver/loss.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/core/check.h"

namespace vesta {
namespace {

double PositiveScale(double a) {
  if (!(a > 0 && std::isfinite(a))) Fail("the scale of a loss is {}; choose it above 0", a);
  return a;
}

// Slopes stay positive, so that a block far out keeps a weight that can be divided by.
double Positive(double slope) { return std::max(slope, std::numeric_limits<double>::min()); }

}  // namespace

Loss::Value TrivialLoss::Evaluate(double s) const { return {s, 1, 0}; }

HuberLoss::HuberLoss(double a) : a_(PositiveScale(a)) {}
Loss::Value HuberLoss::Evaluate(double s) const {
  if (s <= a_ * a_) return {s, 1, 0};
  const double norm = std::sqrt(s), slope = Positive(a_ / norm);
  return {2 * a_ * norm - a_ * a_, slope, -slope / (2 * s)};
}

SoftLOneLoss::SoftLOneLoss(double a) : b_(PositiveScale(a) * a) {}
Loss::Value SoftLOneLoss::Evaluate(double s) const {
  const double sum = 1 + s / b_, root = std::sqrt(sum), slope = Positive(1 / root);
  return {2 * b_ * (root - 1), slope, -slope / (2 * b_ * sum)};
}

CauchyLoss::CauchyLoss(double a) : b_(PositiveScale(a) * a) {}
Loss::Value CauchyLoss::Evaluate(double s) const {
  const double slope = Positive(1 / (1 + s / b_));
  return {b_ * std::log1p(s / b_), slope, -slope * slope / b_};
}

ArctanLoss::ArctanLoss(double a) : a_(PositiveScale(a)) {}
Loss::Value ArctanLoss::Evaluate(double s) const {
  const double ratio = s / a_, slope = Positive(1 / (1 + ratio * ratio));
  return {a_ * std::atan(ratio), slope, -2 * ratio / a_ * slope * slope};
}

TukeyLoss::TukeyLoss(double a) : b_(PositiveScale(a) * a) {}
Loss::Value TukeyLoss::Evaluate(double s) const {
  if (s > b_) return {b_ / 3, 0, 0};
  const double left = 1 - s / b_;
  return {b_ / 3 * (1 - left * left * left), left * left, -2 / b_ * left};
}

LossCorrection::LossCorrection(const Loss::Value& value, double s)
    : root_first_(std::sqrt(value.first)), residual_scale_(root_first_) {
  if (s <= 0 || value.second <= 0) return;
  // alpha solves alpha^2 / 2 - alpha - s rho'' / rho' = 0; here it is negative.
  const double alpha = 1 - std::sqrt(1 + 2 * s * value.second / value.first);
  alpha_over_s_ = alpha / s;
  residual_scale_ = root_first_ / (1 - alpha);
}

}  // namespace vesta
