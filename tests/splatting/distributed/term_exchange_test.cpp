// SPDX-License-Identifier: Apache-2.0
#include "splatting/distributed/term_exchange.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "splatting/distributed/sum_of_views.h"
#include "tests/splatting/train/synthetic_views.h"
#include "tests/support/thread_ranks.h"
#include "tests/support/throws_error.h"

namespace vesta::gs {
namespace {

// The state of a process after some iterations over all views.
struct After {
  std::vector<float> x, pull;
  Index observed = 0;
  double objective = 0;
  friend bool operator==(const After&, const After&) = default;
};

// x is updated by the gradients themselves. ranks: null for one process with all views.
After Iterate(const test::SyntheticViews& all, Communicator* ranks) {
  const auto count = static_cast<Index>(all.views.size());
  const ProcessGroup processes(ranks);
  const Share own = processes.OwnShare(count);
  DensityControl<Host> density({}, 1);
  density.ResetStatistics(all.gaussians());
  SumOfViews<Host> sum;
  TermExchange exchange;
  After after;
  after.x.assign(all.views[0].gradient.size(), 1);
  // The second iteration must not contain the first.
  for (int iteration = 0; iteration < 2; ++iteration) {
    sum.Begin(all.layout, count, &density);
    std::vector<float> gradient(after.x.size());
    for (Index k = own.begin; k < own.end; ++k) {
      const test::SyntheticViews::View& view = all.views[static_cast<std::size_t>(k)];
      gradient = view.gradient;
      sum.Add(k, view.pull_view(), gradient.data(), [&] { return view.cost; });
    }
    if (ranks) exchange.AllGather(*ranks, &sum);
    after.objective = sum.Finish(gradient.data()).objective;
    for (std::size_t i = 0; i < gradient.size(); ++i) after.x[i] -= gradient[i];
  }
  after.pull = {density.pull().begin(), density.pull().end()};
  after.observed = density.views();
  return after;
}

TEST(TermExchange, LeavesAllWithTheSumOfOneProcess) {
  for (const int views : {2, 3, 5}) {
    const test::SyntheticViews all(views, splat::NumAttributes(2), 1100);
    const After expected = Iterate(all, nullptr);
    // Also fewer views than processes.
    for (const int count : {1, 2, 3, 6}) {
      vesta::test::OnThreadRanks(count, [&](Communicator& ranks) {
        EXPECT_EQ(Iterate(all, &ranks), expected) << views << " views, process " << ranks.rank() << " of " << count;
      });
    }
  }
}

TEST(TermExchange, ProcessesThatTrainOtherModelsAreRefused) {
  EXPECT_THAT(
      [] {
        vesta::test::OnThreadRanks(2, [](Communicator& ranks) {
          Iterate(test::SyntheticViews(2, splat::NumAttributes(1), 75 + ranks.rank()), &ranks);
        });
      },
      ThrowsError(kBadArgument, "75", "76"));
}

}  // namespace
}  // namespace vesta::gs
