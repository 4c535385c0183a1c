// SPDX-License-Identifier: Apache-2.0
// Checks that a result does not depend on the number of threads.
#pragma once

#include <gtest/gtest.h>

#include "kernels/core/parallel.h"

namespace vesta::test {

// make() gives equal results (==) with one, two and three threads. This compares all bits of numbers except the sign of
// zero; NaN fails.
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
