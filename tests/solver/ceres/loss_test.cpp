// SPDX-License-Identifier: Apache-2.0
// Robust losses. Adapted from Ceres 2.1's test internal/ceres/loss_function_test.cc; docs/ceres_tests.md lists the
// omitted cases. tests/solver/loss_test.cpp compares the values with Ceres.
#include "solver/loss.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace vesta::test {
namespace {

template <class L, class... Args>
std::shared_ptr<const Loss> Make(Args... args) {
  return std::make_shared<L>(args...);
}

// rho' and rho'' are the slopes of rho and rho'.
void ExpectSlopes(const Loss& loss, double s) {
  constexpr double kStep = 1e-4;
  const Loss::Value value = loss.Evaluate(s), after = loss.Evaluate(s + kStep), before = loss.Evaluate(s - kStep);
  EXPECT_NEAR(value.first, (after.rho - before.rho) / (2 * kStep), 1e-6) << s;
  EXPECT_NEAR(value.second, (after.first - before.first) / (2 * kStep), 1e-6) << s;
}

TEST(CeresCasesLoss, DerivativesAreSlopes) {
  std::vector<std::shared_ptr<const Loss>> losses = {Make<TrivialLoss>(), Make<TolerantLoss>(0.7, 0.4),
                                                     Make<TolerantLoss>(1.3, 0.1)};
  for (const double a : {0.7, 1.3}) {
    for (const auto& loss :
         {Make<HuberLoss>(a), Make<SoftLOneLoss>(a), Make<CauchyLoss>(a), Make<ArctanLoss>(a), Make<TukeyLoss>(a)}) {
      losses.push_back(loss);
    }
  }
  losses.push_back(Make<ComposedLoss>(Make<HuberLoss>(0.7), Make<CauchyLoss>(1.3)));
  losses.push_back(Make<ComposedLoss>(Make<CauchyLoss>(0.7), Make<HuberLoss>(1.3)));
  for (const auto& loss : losses) {
    for (const double s : {0.357, 1.792, 55.5}) ExpectSlopes(*loss, s);
  }
  // The logarithm of 1 + exp(x) equals x in double precision from x = 36.7 on.
  for (const double s : {56.6, 56.7, 56.8, 1020.0}) ExpectSlopes(TolerantLoss(20, 1), s);
}

TEST(CeresCasesLoss, ScaledLosses) {
  const std::vector<std::shared_ptr<const Loss>> losses = {
      nullptr,
      Make<TrivialLoss>(),
      Make<HuberLoss>(0.7),
      Make<SoftLOneLoss>(1.3),
      Make<CauchyLoss>(1.3),
      Make<ArctanLoss>(1.3),
      Make<TolerantLoss>(1.3, 0.1),
      Make<ComposedLoss>(Make<HuberLoss>(0.8), Make<TolerantLoss>(1.3, 0.5))};
  for (const auto& loss : losses) {
    for (const double weight : {0.1, 6.0, 10.0}) {
      const ScaledLoss scaled(loss, weight);
      for (const double s : {0.323, 1.792}) {
        ExpectSlopes(scaled, s);
        const Loss::Value value = loss ? loss->Evaluate(s) : TrivialLoss().Evaluate(s);
        EXPECT_EQ(scaled.Evaluate(s).rho, weight * value.rho);
        EXPECT_EQ(scaled.Evaluate(s).second, weight * value.second);
      }
    }
  }
}

TEST(CeresCasesLoss, ValuesAtZero) {
  constexpr double kB = 0.7 * 0.7;
  const struct {
    std::shared_ptr<const Loss> loss;
    double second;
  } cases[] = {{Make<TrivialLoss>(), 0},         {Make<HuberLoss>(0.7), 0},  {Make<SoftLOneLoss>(0.7), -0.5 / kB},
               {Make<CauchyLoss>(0.7), -1 / kB}, {Make<ArctanLoss>(0.7), 0}, {Make<TukeyLoss>(0.7), -2 / kB}};
  for (const auto& [loss, second] : cases) {
    const Loss::Value value = loss->Evaluate(0);
    EXPECT_EQ(value.rho, 0);
    EXPECT_EQ(value.first, 1);
    EXPECT_NEAR(value.second, second, 1e-14);
  }
  EXPECT_EQ(TolerantLoss(0.7, 0.4).Evaluate(0).rho, 0);
}

}  // namespace
}  // namespace vesta::test
