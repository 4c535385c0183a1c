// SPDX-License-Identifier: Apache-2.0
#include "bench/growth/mcmc.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace vesta::bench {
namespace {

TEST(Mcmc, CopiesKeepTheOpacityInTheCentreAndItsIntegral) {
  for (const double opacity : {0.01, 0.3, 0.9}) {
    for (const int copies : {1, 2, 3, 10}) {
      const SharedShape shape = ShapeOfCopies(opacity, copies);
      EXPECT_NEAR(1 - std::pow(1 - shape.opacity, copies), opacity, 1e-12);
      double integral = 0;
      constexpr double kStep = 1e-3;
      for (double x = -12; x < 12; x += kStep) {
        const double one = shape.opacity * std::exp(-x * x / (2 * shape.scale * shape.scale));
        integral += kStep * (1 - std::pow(1 - one, copies));
      }
      EXPECT_NEAR(integral, opacity * std::sqrt(2 * std::numbers::pi), 1e-6) << opacity << ", " << copies;
    }
  }
}

}  // namespace
}  // namespace vesta::bench
