// SPDX-License-Identifier: Apache-2.0
// Has the label "threads": also runs under the thread sanitizer (preset tsan).
#include "kernels/core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <future>
#include <stdexcept>
#include <thread>
#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/vector_backend.h"

namespace vesta {
namespace {

class Parallel : public ::testing::TestWithParam<int> {
 protected:
  void SetUp() override { SetNumThreads(GetParam()); }
  void TearDown() override { SetNumThreads(0); }
};
INSTANTIATE_TEST_SUITE_P(Threads, Parallel, ::testing::Values(1, 2, 4));

TEST_P(Parallel, ChunksCoverTheRangeOnceAndBeginAtMultiplesOfTheGrain) {
  for (const Index count : {0, 1, 99, 100, 101, 1234}) {
    std::vector<int> visits(static_cast<std::size_t>(count), 0);
    std::atomic<int> misplaced{0};
    ParallelForChunks(count, 100, [&](Index begin, Index end) {
      if (begin % 100 != 0 || (end % 100 != 0 && end != count) || end - begin > 100) {
        // A single chunk may be the whole range.
        if (!(begin == 0 && end == count && count <= 100)) ++misplaced;
      }
      for (Index i = begin; i < end; ++i) ++visits[static_cast<std::size_t>(i)];
    });
    EXPECT_EQ(misplaced, 0);
    for (const int v : visits) EXPECT_EQ(v, 1);
  }
}

TEST_P(Parallel, SumsAddInTheOrderOfTheChunks) {
  // 1e16 + 1 - 1e16 depends on the order.
  const auto body = [](Index begin, Index) { return begin == 0 ? 1e16 : begin == 1 ? 1.0 : -1e16; };
  EXPECT_EQ(ParallelSum<double>(3, 1, body), 1e16 + 1.0 - 1e16);
  EXPECT_EQ(ParallelSum<double>(0, 1, body), 0.0);
}

TEST_P(Parallel, ExceptionsReachTheCaller) {
  EXPECT_THROW(ParallelFor(1000, 10,
                           [](Index i) {
                             if (i == 777) throw std::runtime_error("777");
                           }),
               std::runtime_error);
}

TEST_P(Parallel, LoopsNest) {
  std::vector<double> sums(8);
  ParallelFor(8, 1, [&](Index i) {
    sums[static_cast<std::size_t>(i)] =
        ParallelSum<double>(100, 7, [&](Index begin, Index end) { return static_cast<double>((end - begin) * i); });
  });
  for (std::size_t i = 0; i < sums.size(); ++i) EXPECT_EQ(sums[i], 100.0 * static_cast<double>(i));
}

TEST_P(Parallel, VectorAndBlockOperationsRunClean) {
  using B = CpuBackend<float>;
  constexpr Index kSize = 60000;
  B backend;
  B::Vector x(kSize), y(kSize), z(kSize);
  backend.Fill(1, x);
  backend.Fill(2, y);
  backend.Axpby(0.5, x, 1, y);
  backend.Multiply(x, y, z);
  backend.AddScaled(2, x, y, z);
  EXPECT_EQ(backend.Dot(x, z), 7.5 * kSize);
  EXPECT_EQ(backend.MaxAbs(z), 7.5);
  EXPECT_TRUE(backend.AllFinite(z));
  BlockDiagonal<B> blocks(kSize, {{3, kSize / 3, 0, kSize / 3, 1}});
  blocks.AddToDiagonal(1, y);
  EXPECT_EQ(blocks.Factorize(), 0);
  blocks.Solve(y, z);
  EXPECT_NEAR(backend.Dot(x, z), kSize, 1e-2);
}

// The sanitizer sees code on these threads.
TEST(ParallelDeathTest, APlantedRaceIsReported) {
#if defined(__SANITIZE_THREAD__)
  ::testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(
      {
        SetNumThreads(2);
        // Each of two chunks waits until the other has started, so that two threads write at any machine load. Relaxed,
        // so that the waiting itself does not synchronise them.
        int shared = 0;
        std::atomic<int> begun{0};
        ParallelFor(2, 1, [&](Index) {
          begun.fetch_add(1, std::memory_order_relaxed);
          while (begun.load(std::memory_order_relaxed) < 2) std::this_thread::yield();
          ++shared;
        });
        std::exit(shared > 0 ? 0 : 1);
      },
      ::testing::ExitedWithCode(66), "data race");
#else
  GTEST_SKIP() << "not built with the thread sanitizer (preset tsan)";
#endif
}

TEST(ParallelThreads, ANegativeNumberIsRefused) {
  SetNumThreads(2);
  EXPECT_THROW(SetNumThreads(-1), Error);
  EXPECT_EQ(NumThreads(), 2);
  SetNumThreads(0);
}

TEST(Background, RunsTasksInTheirOrder) {
  std::vector<int> done;  // protected only by the order of the tasks
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
