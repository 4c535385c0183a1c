// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/block_kernel.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/emulated_block.h"

namespace vesta {
namespace {

struct Term {
  const double* x;
  double operator()(Index i) const { return x[i]; }
};

template <class Add>
std::vector<double> Reduce(const std::vector<double>& x, const Add& add, Index chunk, test::ThreadOrder order) {
  const auto size = static_cast<Index>(x.size());
  const Index chunks = (size + chunk - 1) / chunk;
  std::vector<double> partials(static_cast<std::size_t>(chunks));
  test::Emulate(ReduceChunks<Term, Add>{{x.data()}, add, size, chunk, partials.data()}, chunks, order);
  return partials;
}

TEST(BlockKernel, ChunksAreReducedInAnyOrderOfThreads) {
  test::Random random(1);
  const auto x = random.NormalVector<double>(2500);
  const std::vector<double> expected = Reduce(x, AddUp{}, 1000, test::ThreadOrder::kForward);
  ASSERT_EQ(expected.size(), 3U);
  for (std::size_t c = 0; c < 3; ++c) {
    const auto begin = x.begin() + static_cast<std::ptrdiff_t>(1000 * c);
    EXPECT_NEAR(expected[c], std::accumulate(begin, c == 2 ? x.end() : begin + 1000, 0.0), 1e-12);
  }
  EXPECT_EQ(Reduce(x, AddUp{}, 1000, test::ThreadOrder::kBackward), expected);
  EXPECT_EQ(Reduce(x, AddUp{}, 1000, test::ThreadOrder::kShuffled), expected);
}

TEST(BlockKernel, NaNWinsAMaximum) {
  std::vector<double> x(600, 1.0);
  x[300] = 7;
  EXPECT_EQ(Reduce(x, LargestOrNaN{}, 600, test::ThreadOrder::kForward), std::vector<double>{7});
  x[10] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(Reduce(x, LargestOrNaN{}, 600, test::ThreadOrder::kForward)[0]));
}

TEST(BlockKernel, ReductionsHaveFewChunksOfAFixedSize) {
  for (const Index size :
       {Index{0}, Index{1}, Index{4096}, Index{4097}, Index{8'388'608}, Index{59'000'000}, Index{3'000'000'000}}) {
    const Index chunk = ChunkSize(size);
    EXPECT_EQ(chunk % 256, 0) << size;
    EXPECT_LE((size + chunk - 1) / chunk, kMaxChunks) << size;
  }
}

// The emulator detects the faults it was made for.
struct ForgetsABarrier {
  static constexpr int kThreads = 64;
  struct Shared {
    int value[kThreads];
  };
  int* out;
  template <class Block>
  void operator()(Block& block, Shared& shared) const {
    shared.value[block.thread()] = 1 + block.thread();
    out[block.thread()] = shared.value[(block.thread() + 1) % kThreads];
    block.Sync();
  }
};

struct HalfReachABarrier {
  static constexpr int kThreads = 32;
  struct Shared {};
  template <class Block>
  void operator()(Block& block, Shared&) const {
    if (block.thread() < 16) block.Sync();
  }
};

TEST(EmulatedBlock, AMissingBarrierDependsOnTheOrder) {
  std::vector<int> forward(64), backward(64);
  test::Emulate(ForgetsABarrier{forward.data()}, 1, test::ThreadOrder::kForward);
  test::Emulate(ForgetsABarrier{backward.data()}, 1, test::ThreadOrder::kBackward);
  EXPECT_NE(forward, backward);
}

TEST(EmulatedBlock, ABarrierThatSomeThreadsNeverReachIsAnError) {
  EXPECT_THROW(test::Emulate(HalfReachABarrier{}, 1), std::logic_error);
}

// Adds the threads' numbers, or throws in one of them while others wait.
struct SumsOrThrows {
  static constexpr int kThreads = 64;
  struct Shared {
    int lanes[kThreads];
  };
  int thrower;
  int* out;
  template <class Block>
  void operator()(Block& block, Shared& shared) const {
    block.Sync();
    if (block.thread() == thrower) throw std::runtime_error("thrown in a thread");
    const int sum = ReduceBlock<kThreads>(block, shared.lanes, block.thread(), AddUp{});
    if (block.thread() == 0) *out = sum;
  }
};

TEST(EmulatedBlock, RunsAgainAfterAThreadThrew) {
  test::FiberBlock fibers(SumsOrThrows::kThreads, test::ThreadOrder::kShuffled, 1);
  int sum = 0;
  for (int run = 0; run < 3; ++run) {
    EXPECT_THROW(test::Emulate(SumsOrThrows{20 * run, &sum}, 1, fibers), std::runtime_error);
    sum = 0;
    test::Emulate(SumsOrThrows{-1, &sum}, 2, fibers);
    EXPECT_EQ(sum, 64 * 63 / 2);
  }
}

}  // namespace
}  // namespace vesta
