// SPDX-License-Identifier: Apache-2.0
// Residuals and Jacobians of cost functions of vesta and of Ceres, for comparison.
#pragma once

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "solver/cost_function.h"

namespace vesta::test {

using Blocks = std::vector<std::vector<double>>;

struct Derivatives {
  std::vector<double> residuals;
  Blocks jacobians;  // row-major; empty for blocks that are not wanted
};

inline void ExpectNear(const std::vector<double>& a, const std::vector<double>& b, double tolerance) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], tolerance * std::max(1.0, std::abs(b[i]))) << i;
}

inline std::vector<int> SizesOf(const CostFunction& cost) {
  return {cost.block_sizes().begin(), cost.block_sizes().end()};
}
inline std::vector<int> SizesOf(const ceres::CostFunction& cost) { return cost.parameter_block_sizes(); }

// wanted: bit b requests the Jacobian of block b. Also checks an evaluation without Jacobians.
template <class Cost>
Derivatives Evaluate(const Cost& cost, const Blocks& blocks, unsigned wanted = ~0U) {
  const std::vector<int> sizes = SizesOf(cost);
  const auto rows = static_cast<std::size_t>(cost.num_residuals());
  Derivatives result{std::vector<double>(rows, -1e5), Blocks(sizes.size())};
  std::vector<const double*> parameters;
  std::vector<double*> jacobians;
  for (std::size_t b = 0; b < sizes.size(); ++b) {
    parameters.push_back(blocks.at(b).data());
    if ((wanted >> b & 1U) != 0) result.jacobians[b].assign(rows * static_cast<std::size_t>(sizes[b]), -1e5);
    jacobians.push_back(result.jacobians[b].empty() ? nullptr : result.jacobians[b].data());
  }
  EXPECT_TRUE(cost.Evaluate(parameters.data(), result.residuals.data(), jacobians.data()));
  std::vector<double> alone(rows, -1e5);
  EXPECT_TRUE(cost.Evaluate(parameters.data(), alone.data(), nullptr));
  ExpectNear(alone, result.residuals, 1e-14);
  return result;
}

inline void ExpectNear(const Derivatives& a, const Derivatives& b, double tolerance) {
  ExpectNear(a.residuals, b.residuals, tolerance);
  ASSERT_EQ(a.jacobians.size(), b.jacobians.size());
  for (std::size_t k = 0; k < a.jacobians.size(); ++k) ExpectNear(a.jacobians[k], b.jacobians[k], tolerance);
}

}  // namespace vesta::test
