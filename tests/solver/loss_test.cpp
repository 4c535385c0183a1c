// SPDX-License-Identifier: Apache-2.0
#include "solver/loss.h"

#include <ceres/loss_function.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "kernels/core/check.h"

namespace vesta {
namespace {

struct Pair {
  const char* name;
  std::shared_ptr<const Loss> ours;
  std::shared_ptr<const ceres::LossFunction> theirs;
};

std::vector<Pair> Losses(double a) {
  return {
      {"trivial", std::make_shared<TrivialLoss>(), std::make_shared<ceres::TrivialLoss>()},
      {"huber", std::make_shared<HuberLoss>(a), std::make_shared<ceres::HuberLoss>(a)},
      {"soft l1", std::make_shared<SoftLOneLoss>(a), std::make_shared<ceres::SoftLOneLoss>(a)},
      {"cauchy", std::make_shared<CauchyLoss>(a), std::make_shared<ceres::CauchyLoss>(a)},
      {"arctan", std::make_shared<ArctanLoss>(a), std::make_shared<ceres::ArctanLoss>(a)},
      {"tukey", std::make_shared<TukeyLoss>(a), std::make_shared<ceres::TukeyLoss>(a)},
      {"tolerant", std::make_shared<TolerantLoss>(0.5, a), std::make_shared<ceres::TolerantLoss>(0.5, a)},
      {"composed", std::make_shared<ComposedLoss>(std::make_shared<HuberLoss>(a), std::make_shared<CauchyLoss>(2 * a)),
       std::make_shared<ceres::ComposedLoss>(new ceres::HuberLoss(a), ceres::TAKE_OWNERSHIP,
                                             new ceres::CauchyLoss(2 * a), ceres::TAKE_OWNERSHIP)},
      {"scaled", std::make_shared<ScaledLoss>(std::make_shared<HuberLoss>(a), 0.3),
       std::make_shared<ceres::ScaledLoss>(new ceres::HuberLoss(a), 0.3, ceres::TAKE_OWNERSHIP)},
      {"weight", std::make_shared<ScaledLoss>(nullptr, a),
       std::make_shared<ceres::ScaledLoss>(nullptr, a, ceres::TAKE_OWNERSHIP)}};
}

TEST(Loss, ValuesAndDerivativesAreCeress) {
  for (const double a : {0.1, 1.0, 7.5}) {
    for (const Pair& pair : Losses(a)) {
      for (const double s : {0.0, 1e-6, 0.009, 0.3, 1.0, 2.0, 56.0, 57.0, 1e4}) {
        double expected[3];
        pair.theirs->Evaluate(s, expected);
        const Loss::Value value = pair.ours->Evaluate(s);
        // Ceres's values of rho cancel for s far below a^2, so their errors are relative to a^2. In the same way
        // Tukey's slope cancels for s near a^2.
        EXPECT_NEAR(value.rho, expected[0], 1e-14 * (std::abs(expected[0]) + a * a)) << pair.name << " at " << s;
        EXPECT_NEAR(value.first, expected[1], 1e-14 * std::abs(expected[1]) + 1e-18) << pair.name << " at " << s;
        // Ceres's tolerant loss returns 0 where its curvature is below rounding.
        EXPECT_NEAR(value.second, expected[2], 1e-13 * std::abs(expected[2]) + 1e-16 / a) << pair.name << " at " << s;
      }
    }
  }
}

// A value and its exact counterpart, computed in long double by a formula that does not cancel.
struct Exact {
  const char* name;
  std::shared_ptr<const Loss> loss;
  std::function<long double(long double s)> rho, first, second;
};

std::vector<Exact> ExactLosses(double a) {
  using Real = long double;
  const Real c = a, b = static_cast<Real>(a * a);
  const Real at_zero = 1 / (1 + std::exp(Real(0.5) / c));
  return {
      {"huber", std::make_shared<HuberLoss>(a), [=](Real s) { return s <= b ? s : c * (2 * std::sqrt(s) - c); },
       [=](Real s) { return s <= b ? 1 : c / std::sqrt(s); },
       [=](Real s) { return s <= b ? 0 : -c / (2 * s * std::sqrt(s)); }},
      {"soft l1", std::make_shared<SoftLOneLoss>(a), [=](Real s) { return 2 * b * std::expm1(std::log1p(s / b) / 2); },
       [=](Real s) { return 1 / std::sqrt(1 + s / b); },
       [=](Real s) { return -1 / (2 * b * (1 + s / b) * std::sqrt(1 + s / b)); }},
      {"cauchy", std::make_shared<CauchyLoss>(a), [=](Real s) { return b * std::log1p(s / b); },
       [=](Real s) { return 1 / (1 + s / b); }, [=](Real s) { return -b / ((b + s) * (b + s)); }},
      {"arctan", std::make_shared<ArctanLoss>(a), [=](Real s) { return c * std::atan(s / c); },
       [=](Real s) { return 1 / (1 + s / c * s / c); },
       [=](Real s) { return -2 * s / c / c / (1 + s / c * s / c) / (1 + s / c * s / c); }},
      {"tukey", std::make_shared<TukeyLoss>(a),
       [=](Real s) { return s >= b ? b / 3 : -b / 3 * std::expm1(3 * std::log1p(-s / b)); },
       [=](Real s) { return s > b ? 0 : (1 - s / b) * (1 - s / b); },
       [=](Real s) { return s > b ? 0 : -2 / b * (1 - s / b); }},
      // rho: the first terms of the series in s / c; log1p of a small number; a difference of logarithms.
      {"tolerant", std::make_shared<TolerantLoss>(0.5, a),
       [=](Real s) {
         const Real u = s / c, t = (s - Real(0.5)) / c;
         if (u < 1e-5) return s * at_zero * (1 + u / 2 * (1 - at_zero) * (1 + u / 3 * (1 - 2 * at_zero)));
         if (u < 1) return c * std::log1p(std::expm1(u) * at_zero);
         if (t > 50) return c * (t + std::exp(-t) - std::log1p(std::exp(Real(-0.5) / c)));
         return c * (std::log1p(std::exp(t)) - std::log1p(std::exp(Real(-0.5) / c)));
       },
       [=](Real s) { return 1 / (1 + std::exp(-(s - Real(0.5)) / c)); },
       [=](Real s) {
         const Real t = (s - Real(0.5)) / c;
         return 1 / (1 + std::exp(-t)) / (1 + std::exp(t)) / c;
       }}};
}

// Expects equality up to `units` rounding errors, or up to underflow.
void ExpectExact(double value, long double exact, double units) {
  using Limits = std::numeric_limits<double>;
  if (std::abs(exact) > Limits::max()) return;
  EXPECT_LE(std::abs(value - exact), units * Limits::epsilon() * std::abs(exact) + Limits::min())
      << value << " for " << static_cast<double>(exact);
}

TEST(Loss, IsAccurateAtEveryScale) {
  for (const double a : {0.1, 1.0, 3.0}) {
    for (const Exact& exact : ExactLosses(a)) {
      for (int exponent = -300; exponent <= 300; ++exponent) {
        for (const double factor : {1.0, 2.4, 5.6}) {
          const double s = factor * std::pow(10.0, exponent);
          SCOPED_TRACE(testing::Message() << exact.name << " " << a << " at " << s);
          const Loss::Value value = exact.loss->Evaluate(s);
          // exp(x) has |x| times the relative error of x; beyond 750 it underflows.
          const bool exponential = std::strcmp(exact.name, "tolerant") == 0;
          const double units = exponential ? 8 + std::min(750.0, std::abs(s - 0.5) / a) : 8;
          ExpectExact(value.rho, exact.rho(s), units);
          ExpectExact(value.first, exact.first(s), units);
          ExpectExact(value.second, exact.second(s), units);
        }
      }
    }
  }
}

TEST(Loss, OutliersBeyondTheRangeOfSKeepAFiniteCost) {
  // s / a^2 overflows; rho = 2 a sqrt(s) does not.
  const Loss::Value value = SoftLOneLoss(1e-10).Evaluate(1e300);
  EXPECT_NEAR(value.rho / 2e140, 1, 1e-14);
  EXPECT_GT(value.first, 0);
}

TEST(Loss, ScalesMustBePositive) {
  EXPECT_THROW(TukeyLoss(1e-170), Error);
  EXPECT_THROW(SoftLOneLoss(1e170), Error);
  EXPECT_THROW(HuberLoss(0), Error);
  EXPECT_THROW(CauchyLoss(-1), Error);
  EXPECT_THROW(TukeyLoss(std::nan("")), Error);
  EXPECT_THROW(TolerantLoss(1, 0), Error);
  EXPECT_THROW(TolerantLoss(-1, 1), Error);
  EXPECT_THROW(ScaledLoss(nullptr, -1), Error);
  EXPECT_THROW(ComposedLoss(nullptr, std::make_shared<TrivialLoss>()), Error);
}

// The gradient J^T f and curvature J^T J of the corrected block.
void ExpectCorrection(const Loss::Value& value, const Eigen::VectorXd& f, const Eigen::MatrixXd& jacobian) {
  const double s = f.squaredNorm();
  Eigen::VectorXd corrected_f = f;
  Eigen::MatrixXd corrected_j = jacobian;  // column-major
  LossCorrection(value, s).Apply(static_cast<int>(f.size()), static_cast<int>(jacobian.cols()), corrected_f.data(),
                                 corrected_j.data(), 1, static_cast<int>(f.size()));
  const Eigen::VectorXd gradient = value.first * jacobian.transpose() * f;
  EXPECT_LE((corrected_j.transpose() * corrected_f - gradient).norm(), 1e-13 * gradient.norm());
  const Eigen::MatrixXd weight =
      value.first * Eigen::MatrixXd::Identity(f.size(), f.size()) + 2 * std::max(value.second, 0.0) * f * f.transpose();
  const Eigen::MatrixXd curvature = jacobian.transpose() * weight * jacobian;
  EXPECT_LE((corrected_j.transpose() * corrected_j - curvature).norm(), 1e-13 * curvature.norm());
}

TEST(Loss, CorrectionGivesTheGradientAndTheCurvature) {
  const Eigen::Vector3d f(0.3, -1.2, 0.7);
  const Eigen::MatrixXd jacobian =
      Eigen::MatrixXd::NullaryExpr(3, 2, [](auto i, auto j) { return std::sin(1.0 + 2 * i + 5 * j); });
  for (const Pair& pair : Losses(0.5)) {
    const Loss::Value value = pair.ours->Evaluate(f.squaredNorm());
    if (value.first > 0) ExpectCorrection(value, f, jacobian);
  }
  // A loss that grows faster than the square has rho'' > 0; there the second derivative helps.
  ExpectCorrection({1.0, 0.8, 0.4}, f, jacobian);
  ExpectCorrection({0.0, 0.8, 0.4}, Eigen::Vector3d::Zero(), jacobian);
}

}  // namespace
}  // namespace vesta
