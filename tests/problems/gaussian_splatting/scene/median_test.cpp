// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "problems/gaussian_splatting/scene/camera_rig.h"

namespace vesta::gs {
namespace {

TEST(Median, IsTheMiddleOneOrTheUpperOfTwo) {
  EXPECT_EQ(Median<double>({7}), 7);
  EXPECT_EQ(Median<double>({3, -1, 2}), 2);
  EXPECT_EQ(Median<float>({4, 1, 3, 2}), 3);
}

}  // namespace
}  // namespace vesta::gs
