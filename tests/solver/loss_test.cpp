// SPDX-License-Identifier: Apache-2.0
#include "solver/loss.h"

#include <ceres/loss_function.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>

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
        // log1p and 1 - (1 - x)^3 differ from Ceres's formulas in the last digits relative to the terms of their sums.
        EXPECT_NEAR(value.rho, expected[0], 1e-14 * (std::abs(expected[0]) + a * a)) << pair.name << " at " << s;
        EXPECT_NEAR(value.first, expected[1], 1e-14 * std::abs(expected[1])) << pair.name << " at " << s;
        // Ceres's tolerant loss returns 0 where its curvature is below rounding.
        EXPECT_NEAR(value.second, expected[2], 1e-13 * std::abs(expected[2]) + 1e-16 / a) << pair.name << " at " << s;
      }
    }
  }
}

TEST(Loss, ScalesMustBePositive) {
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
