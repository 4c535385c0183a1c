// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/divisor.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "kernels/core/random.h"

namespace vesta {
namespace {

TEST(Divisor, IsExactForEveryIndex) {
  constexpr Index kLargest = std::numeric_limits<Index>::max();
  CounterRandom random(1, 2);
  std::vector<Index> divisors = {
      1, 2, 3, 7, 16, 255, 1'000'003, (Index{1} << 31) - 1, Index{1} << 32, kLargest - 1, kLargest};
  for (int i = 0; i < 200; ++i) divisors.push_back(1 + static_cast<Index>(random.Bits() >> (1 + i % 62)));
  for (const Index d : divisors) {
    const Divisor divisor(d);
    std::vector<Index> dividends = {0, 1, d - 1, d, kLargest, kLargest - 1, kLargest / d * d, kLargest / d * d - 1};
    if (d < kLargest) dividends.push_back(d + 1);
    for (int i = 0; i < 100; ++i) dividends.push_back(static_cast<Index>(random.Bits() >> (1 + i % 62)));
    for (const Index x : dividends) {
      const Division found = divisor.Divide(x);
      ASSERT_EQ(found.quotient, x / d) << x << " / " << d;
      ASSERT_EQ(found.remainder, x % d) << x << " / " << d;
    }
  }
}

}  // namespace
}  // namespace vesta
