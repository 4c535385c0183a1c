// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/step_differences.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <span>

namespace vesta {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

TEST(StepDifferences, AreExactToWhatTheySay) {
  // Slopes of very different sizes, a square root, a kink, and a function that is undefined below 0.
  const auto f = [](double t, std::span<double> out) {
    out[0] = 1e9 * std::exp(3 * t) + 1;
    out[1] = 1e-9 * std::sin(t) + 1e-12;
    out[2] = std::sqrt(1 + t);
    out[3] = 7;
    out[4] = std::abs(t - 1e-9);
    out[5] = std::log(t);
  };
  for (const double largest : {1e-4, 1e-2, 0.5, 10.0}) {
    const StepDifferences differences = DifferenceAlong(f, 6, largest, kEpsilon, 0);
    const double exact[] = {3e9, 1e-9, 0.5, 0};
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_LE(std::abs(differences.value[i] - exact[i]), 10 * differences.error[i]) << i << " from " << largest;
      EXPECT_LE(differences.error[i], 1e-6 * std::abs(exact[i]) + 1e-9) << i << " from " << largest;
    }
    EXPECT_EQ(differences.error[5], std::numeric_limits<double>::infinity());
  }
}

TEST(StepDifferences, TheRoundingOfThePlaceCounts) {
  // 1/2 (x - 1)^2 around 1, evaluated at x = 1 + t: the slope is 0, but x is rounded to 1e-8, as in float.
  constexpr double kRounded = 1e-8;
  const auto f = [](double t, std::span<double> out) {
    const double x = std::nearbyint((1 + t) / kRounded + 0.3) * kRounded;
    out[0] = 0.5 * (x - 1) * (x - 1);
  };
  const StepDifferences differences = DifferenceAlong(f, 1, 0.1, kRounded, 1);
  EXPECT_LE(std::abs(differences.value[0]), 10 * differences.error[0]);
  EXPECT_GT(differences.error[0], 1e-9);
}

}  // namespace
}  // namespace vesta
