// SPDX-License-Identifier: Apache-2.0
#include "solver/loss.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "kernels/core/check.h"

namespace vesta {
namespace {

double PositiveScale(double a) {
  if (!(a > 0 && std::isfinite(a))) Fail(kBadArgument, "the scale of a loss is {}; choose it above 0", a);
  return a;
}

// a^2, which must be a normal number.
double SquaredScale(double a) {
  const double square = PositiveScale(a) * a;
  if (!std::isnormal(square)) Fail(kBadArgument, "the scale of a loss is {}; choose it from 1e-153 to 1e153", a);
  return square;
}

// Keeps rho' positive, because code divides by it, even for extreme outliers.
double Positive(double slope) { return std::max(slope, std::numeric_limits<double>::min()); }

// log(1 + e^t).
double Softplus(double t) { return std::max(t, 0.0) + std::log1p(std::exp(-std::abs(t))); }

}  // namespace

Loss::Value TrivialLoss::Evaluate(double s) const { return {s, 1, 0}; }

HuberLoss::HuberLoss(double a) : a_(PositiveScale(a)) {}
Loss::Value HuberLoss::Evaluate(double s) const {
  if (s <= a_ * a_) return {s, 1, 0};
  const double norm = std::sqrt(s), slope = Positive(a_ / norm);
  return {2 * a_ * norm - a_ * a_, slope, -slope / (2 * s)};
}

SoftLOneLoss::SoftLOneLoss(double a) : b_(SquaredScale(a)) {}
Loss::Value SoftLOneLoss::Evaluate(double s) const {
  const double ratio = s / b_, root = std::isinf(ratio) ? std::sqrt(s) / std::sqrt(b_) : std::sqrt(1 + ratio);
  const double slope = Positive(1 / root);
  // rho as in the header, but without cancellation for s far below b.
  return {2 * s / (1 + root), slope, -slope / (2 * (b_ + s))};
}

CauchyLoss::CauchyLoss(double a) : b_(SquaredScale(a)) {}
Loss::Value CauchyLoss::Evaluate(double s) const {
  const double slope = Positive(1 / (1 + s / b_));
  return {b_ * std::log1p(s / b_), slope, -slope * slope / b_};
}

ArctanLoss::ArctanLoss(double a) : a_(PositiveScale(a)) {}
Loss::Value ArctanLoss::Evaluate(double s) const {
  const double ratio = s / a_, slope = Positive(1 / (1 + ratio * ratio));
  return {a_ * std::atan(ratio), slope, -2 * ratio / a_ * slope * slope};
}

TukeyLoss::TukeyLoss(double a) : b_(SquaredScale(a)) {}
Loss::Value TukeyLoss::Evaluate(double s) const {
  if (s > b_) return {b_ / 3, 0, 0};
  const double ratio = s / b_, left = (b_ - s) / b_;
  // 1 - (1 - q)^3 = q (3 - 3 q + q^2) does not cancel for small q.
  return {s / 3 * (3 * left + ratio * ratio), left * left, -2 / b_ * left};
}

TolerantLoss::TolerantLoss(double a, double b)
    : a_(a), b_(PositiveScale(b)), at_zero_(Softplus(-a / b)), slope_at_zero_(1 / (1 + std::exp(a / b))) {
  if (!(a >= 0 && std::isfinite(a))) Fail(kBadArgument, "the tolerance of a loss is {}; choose 0 or more", a);
}
Loss::Value TolerantLoss::Evaluate(double s) const {
  // The logistic function of t, and 1 minus it, each without cancellation.
  const double t = (s - a_) / b_, slope = Positive(1 / (1 + std::exp(-t))), rest = 1 / (1 + std::exp(t));
  // The difference cancels for s below b. It is then the logarithm of 1 plus a small number.
  const double ratio = s / b_;
  const double rho = ratio < 1 ? std::log1p(std::expm1(ratio) * slope_at_zero_) : Softplus(t) - at_zero_;
  return {b_ * rho, slope, slope * rest / b_};
}

ComposedLoss::ComposedLoss(std::shared_ptr<const Loss> f, std::shared_ptr<const Loss> g)
    : f_(std::move(f)), g_(std::move(g)) {
  VESTA_CHECK(f_ != nullptr && g_ != nullptr, "a composition needs two losses");
}
Loss::Value ComposedLoss::Evaluate(double s) const {
  const Value g = g_->Evaluate(s), f = f_->Evaluate(g.rho);
  return {f.rho, f.first * g.first, f.second * g.first * g.first + f.first * g.second};
}

ScaledLoss::ScaledLoss(std::shared_ptr<const Loss> loss, double weight) : loss_(std::move(loss)), weight_(weight) {
  if (!(weight >= 0 && std::isfinite(weight)))
    Fail(kBadArgument, "the weight of a loss is {}; choose 0 or more", weight);
}
Loss::Value ScaledLoss::Evaluate(double s) const {
  const Value value = loss_ ? loss_->Evaluate(s) : Value{s, 1, 0};
  return {weight_ * value.rho, weight_ * value.first, weight_ * value.second};
}

LossCorrection::LossCorrection(const Loss::Value& value, double s)
    : root_first_(std::sqrt(value.first)), residual_scale_(root_first_) {
  if (s <= 0 || value.second <= 0) return;
  // alpha solves alpha^2 / 2 - alpha - s rho'' / rho' = 0; here it is negative: 1 - root, without cancellation.
  const double ratio = 2 * value.second / value.first, root = std::sqrt(1 + s * ratio);
  alpha_over_s_ = -ratio / (1 + root);
  residual_scale_ = root_first_ / root;
}

}  // namespace vesta
