// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/linear/cross_product.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "kernels/core/random.h"
#include "tests/support/cpu_isas.h"

namespace vesta {
namespace {

class CrossProductOf : public testing::TestWithParam<Isa> {};

// Sizes with and without unrolled loops, and rows with gaps.
TEST_P(CrossProductOf, IsTheSumOfProducts) {
  CounterRandom random(1, 3);
  const auto values = [&](int count) {
    std::vector<double> result(static_cast<std::size_t>(count));
    for (double& value : result) value = 2 * random.Uniform() - 1;
    return result;
  };
  for (const int cols_a : {1, 3, 5, 9}) {
    for (const int cols_b : {1, 2, 3, 5, 8, 9, 17}) {
      for (const int rows : {1, 2, 7}) {
        const int stride = cols_a + cols_b + 1;
        const std::vector<double> ab = values(rows * stride);
        const std::vector<double> start = values(cols_a * cols_b);
        for (const double sign : {1.0, -1.0}) {
          std::vector<double> w = start;
          const double *a = ab.data(), *b = ab.data() + cols_a;
          AddCrossProductFor(GetParam())({a, stride, cols_a}, {b, stride, cols_b}, rows, sign, w.data());
          std::size_t at = 0;
          for (int r = 0; r < cols_a; ++r) {
            for (int c = 0; c < cols_b; ++c, ++at) {
              double expected = start[at];
              for (int i = 0; i < rows; ++i) expected += sign * a[i * stride + r] * b[i * stride + c];
              EXPECT_EQ(w[at], expected) << cols_a << " x " << cols_b;
            }
          }
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Isas, CrossProductOf, testing::ValuesIn(test::CpuIsas()),
                         [](const auto& tested) { return std::string(IsaName(tested.param)); });

}  // namespace
}  // namespace vesta
