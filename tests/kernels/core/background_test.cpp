// SPDX-License-Identifier: Apache-2.0
// Label threads: run under the thread sanitizer too (preset tsan).
#include "kernels/core/background.h"

#include <gtest/gtest.h>

#include <future>
#include <vector>

namespace vesta {
namespace {

TEST(Background, RunsTasksInTheirOrder) {
  std::vector<int> done;  // guarded by the order alone
  std::promise<void> last;
  Background background;
  for (int i = 0; i < 100; ++i) background.Run([&done, i] { done.push_back(i); });
  background.Run([&] { last.set_value(); });
  last.get_future().wait();
  ASSERT_EQ(done.size(), 100u);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
}

TEST(Background, EndsAfterTheTaskThatRuns) {
  std::promise<void> begun, may_end;
  bool is_over = false;
  {
    Background background;
    background.Run([&] {
      begun.set_value();
      may_end.get_future().wait();
      is_over = true;
    });
    begun.get_future().wait();
    may_end.set_value();
  }
  EXPECT_TRUE(is_over);
}

}  // namespace
}  // namespace vesta
