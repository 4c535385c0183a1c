// SPDX-License-Identifier: Apache-2.0
// The same results for any number of threads.
#pragma once

#include <gtest/gtest.h>

#include "kernels/core/parallel.h"

namespace vesta::test {

// Calls make() with one thread, then with two and three, and expects the same each time. Equal numbers, none of them
// NaN, are equal as bits but for the sign of zeros.
template <class Make>
void ExpectSameForAnyThreads(const Make& make) {
  const int before = NumThreads();
  SetNumThreads(1);
  const auto expected = make();
  for (const int threads : {2, 3}) {
    SetNumThreads(threads);
    EXPECT_TRUE(make() == expected) << threads;
  }
  SetNumThreads(before);
}

}  // namespace vesta::test
