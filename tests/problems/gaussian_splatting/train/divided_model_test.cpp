// Processes that share iterations, each of which steps Gaussians of its own, beside one that does all.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "kernels/core/archive.h"
#include "problems/gaussian_splatting/train/gaussian_owners.h"
#include "problems/gaussian_splatting/train/share_views.h"
#include "problems/gaussian_splatting/train/trained_model.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/problems/gaussian_splatting/train/terms_of_views.h"
#include "tests/support/random.h"
#include "tests/support/thread_ranks.h"

namespace vesta::gs {
namespace {

using Cpu = CpuBackend<float>;
using vesta::test::OnThreadRanks;

// What all processes have after an iteration.
struct After {
  std::vector<float> x, pull;
  std::vector<int> seen;
  double objective = 0;
  friend bool operator==(const After&, const After&) = default;
};

// x by a step that is the gradient itself; ranks: null for one that does all.
After Iterate(const test::MadeUpViews& all, Ranks* ranks) {
  const auto count = static_cast<Index>(all.views.size());
  const GaussianOwners owners(all.layout.model, ranks ? ranks->size() : 1);
  DensityControl<Host> density({}, 1, 0);
  density.Forget(all.gaussians());
  SumOfViews<Host> sum;
  ViewExchange exchange;
  After after;
  after.x.assign(all.views[0].gradient.size(), 1);
  // Twice: nothing of the first is left in the second.
  for (int iteration = 0; iteration < 2; ++iteration) {
    sum.Begin(all.layout, count, &density);
    std::vector<float> gradient(after.x.size());
    for (Index k = 0; k < count; ++k) {
      if (ranks && k % ranks->size() != ranks->rank()) continue;
      const test::MadeUpViews::View& view = all.views[static_cast<std::size_t>(k)];
      gradient = view.gradient;
      sum.Add(k, view.pulls(), gradient.data(), [&] { return view.cost; });
    }
    if (ranks) exchange.ToOwners(*ranks, owners, &sum);
    after.objective = sum.Finish(gradient.data()).objective;
    const GaussianRange own = owners.Of(ranks ? ranks->rank() : 0);
    for (int a = 0; a < splat::kMaxAttributes; ++a) {
      for (Index i = 0; i < all.layout.model.Rows(a); ++i) {
        const auto at = static_cast<std::size_t>(all.layout.model.Offset(a) + i);
        if (i >= own.begin && i < own.end) {
          after.x[at] -= gradient[at];
        } else {
          EXPECT_EQ(gradient[at], 0) << "is another's";
        }
      }
    }
    if (ranks) exchange.FromOwners(*ranks, &sum, after.x.data());
  }
  after.pull = {density.pull().begin(), density.pull().end()};
  after.seen = {density.seen().begin(), density.seen().end()};
  return after;
}

TEST(ViewExchange, LeavesAllWithWhatOneWouldHave) {
  for (const int views : {2, 3, 5}) {
    const test::MadeUpViews all(views, splat::NumAttributes(2), 1100);
    const After expected = Iterate(all, nullptr);
    // Also with fewer views than processes, and fewer chunks of Gaussians.
    for (const int processes : {1, 2, 3, 6}) {
      OnThreadRanks(processes, [&](Ranks& ranks) {
        EXPECT_EQ(Iterate(all, &ranks), expected) << views << " views, process " << ranks.rank() << " of " << processes;
      });
    }
  }
}

class DividedModels : public testing::Test {
 protected:
  static constexpr Index kCount = 1500;  // six chunks

  // Steps, degrees that change, steps, Gaussians that go, steps; the state as it is saved. ranks: null for one that
  // does all.
  std::string Train(Ranks* ranks) const {
    DensityOptions options;
    std::vector<const View*> views;
    for (const View& view : scene_.views) views.push_back(&view);
    TrainedModel<Cpu> trained(test::RandomModel(kCount, 3, 5), Adam<Cpu>({}, AdamMetric::kBlock),
                              DensityControl<Host>(options, 2, 5), UnitViews(views, 0.02), 2);
    trained.DivideAmong(ranks);
    vesta::test::Random random(3);
    const auto steps = [&](int count) {
      for (int k = 0; k < count; ++k) Step(trained, random, ranks);
    };
    steps(8);
    std::vector<std::uint8_t> degrees;
    for (Index i = 0; i < kCount; ++i) degrees.push_back(static_cast<std::uint8_t>(i * i % 4));
    trained.SetDegrees(degrees);
    steps(5);
    std::vector<Index> kept;
    for (Index i = 0; i < kCount; i += i % 7 == 0 ? 2 : 1) kept.push_back(i);
    trained.Keep(kept);
    steps(5);
    if (ranks) trained.GatherFor(std::vector<bool>(static_cast<std::size_t>(ranks->size()), true));
    std::string bytes;
    ArchiveWriter archive([&](std::string_view more) { bytes += more; });
    archive(trained);
    return bytes;
  }

 private:
  // By a gradient that is the same for all, of which each takes what is its own.
  static void Step(TrainedModel<Cpu>& trained, vesta::test::Random& random, Ranks* ranks) {
    const splat::ModelLayout layout = trained.layout();
    const GaussianOwners owners = trained.owners();
    const auto values = random.NormalVector<float>(static_cast<std::size_t>(layout.Size()));
    const auto copy_own = [&](int process, const float* from, float* to) {
      const GaussianRange own = owners.Of(process);
      for (int a = 0; a < splat::kMaxAttributes; ++a) {
        const Index rows = std::min(own.end, layout.Rows(a)) - own.begin, offset = layout.Offset(a) + own.begin;
        if (rows > 0) std::copy_n(from + offset, rows, to + offset);
      }
    };
    copy_own(ranks ? ranks->rank() : 0, values.data(), trained.gradient(splat::kMaxAttributes));
    trained.Step(splat::kMaxAttributes, 1);
    if (!ranks) return;
    const float* x = trained.shared_parameters();
    const std::vector<float> of_all = GatherValues(*ranks, std::vector<float>(x, x + layout.Size()));
    for (int r = 0; r < ranks->size(); ++r) copy_own(r, of_all.data() + r * layout.Size(), trained.shared_parameters());
  }

  Scene scene_ = test::RingOfCameras(3, 40, 30, false);
};

TEST_F(DividedModels, AreInTheEndWhatOneWouldBe) {
  const std::string expected = Train(nullptr);
  for (const int processes : {2, 3, 8}) {
    OnThreadRanks(processes, [&](Ranks& ranks) {
      EXPECT_TRUE(Train(&ranks) == expected) << "process " << ranks.rank() << " of " << processes;
    });
  }
}

}  // namespace
}  // namespace vesta::gs
