// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/model/gather_rows.h"

#include <gtest/gtest.h>

#include <vector>

namespace vesta::gs {
namespace {

TEST(GatherRows, TakesRowsOfEveryAttribute) {
  const std::vector<float> from = {1, 2, 3, 10, 20, 30};
  const std::vector<Index> source = {2, 2, 0, 1};
  const std::vector<std::uint8_t> kept = {1, 0, 1, 1};
  std::vector<float> to(8);
  GatherRows<Host>(RowGathering<Index>{2, 3, 4, source.data(), nullptr, from.data(), to.data()});
  EXPECT_EQ(to, (std::vector<float>{3, 3, 1, 2, 30, 30, 10, 20}));
  GatherRows<Host>(RowGathering<Index>{2, 3, 4, source.data(), kept.data(), from.data(), to.data()});
  EXPECT_EQ(to, (std::vector<float>{3, 0, 1, 2, 30, 0, 10, 20}));
  GatherRows<Host>(RowGathering<Index>{2, 3, 0, nullptr, nullptr, from.data(), nullptr});
}

}  // namespace
}  // namespace vesta::gs
