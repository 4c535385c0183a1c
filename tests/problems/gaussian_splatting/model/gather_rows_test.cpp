#include "problems/gaussian_splatting/model/gather_rows.h"

#include <gtest/gtest.h>

namespace vesta::gs {
namespace {

TEST(GatherRows, TakesRowsOfEveryAttribute) {
  const std::vector<float> data = {1, 2, 3, 10, 20, 30};
  EXPECT_EQ(GatherRows(data, 3, 2, {2, 2, 0, 1}), (std::vector<float>{3, 3, 1, 2, 30, 30, 10, 20}));
  EXPECT_TRUE(GatherRows(data, 3, 2, {}).empty());
}

}  // namespace
}  // namespace vesta::gs
