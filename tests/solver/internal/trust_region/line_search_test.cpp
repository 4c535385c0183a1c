// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/trust_region/line_search.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

namespace vesta {
namespace {

TEST(LineSearch, ShrinksUntilTheCostRisesAndStepsBack) {
  const LineSearchOptions options{.enabled = true, .shrink = 0.5, .max_evaluations = 20};
  // Lowest at 0.3: 1, 0.5, 0.25 fall, 0.125 rises.
  auto result = SearchGamma(options, [](double gamma) { return (gamma - 0.3) * (gamma - 0.3); });
  EXPECT_EQ(result.gamma, 0.25);
  EXPECT_EQ(result.evaluations, 4);
  // The full step is best: two evaluations.
  result = SearchGamma(options, [](double gamma) { return -gamma; });
  EXPECT_EQ(result.gamma, 1);
  EXPECT_EQ(result.evaluations, 2);
}

TEST(LineSearch, InfiniteCostsAreClimbedDownFrom) {
  const LineSearchOptions options{.enabled = true, .shrink = 0.5, .max_evaluations = 20};
  const auto result = SearchGamma(options, [](double gamma) {
    return gamma > 0.2 ? std::numeric_limits<double>::quiet_NaN() : (gamma - 0.1) * (gamma - 0.1);
  });
  EXPECT_EQ(result.gamma, 0.125);
}

TEST(LineSearch, EvaluationsAreLimited) {
  const LineSearchOptions options{.enabled = true, .shrink = 0.5, .max_evaluations = 5};
  const auto result = SearchGamma(options, [](double gamma) { return gamma; });
  EXPECT_EQ(result.evaluations, 5);
  EXPECT_EQ(result.gamma, 0.0625);
}

TEST(LineSearch, UnitsAreSpreadAndTurn) {
  EXPECT_EQ(SpreadUnits(10, 0.3, 0), (std::vector<Index>{0, 3, 6}));
  EXPECT_EQ(SpreadUnits(10, 0.3, 5), (std::vector<Index>{1, 5, 8}));
  EXPECT_EQ(SpreadUnits(1, 0.3, 7), (std::vector<Index>{0}));
  EXPECT_EQ(SpreadUnits(4, 1.0, 3), (std::vector<Index>{0, 1, 2, 3}));
  for (Index turn = 0; turn < 20; ++turn) {
    const auto units = SpreadUnits(7, 0.5, turn);
    EXPECT_EQ(std::set<Index>(units.begin(), units.end()).size(), units.size());
  }
}

}  // namespace
}  // namespace vesta
