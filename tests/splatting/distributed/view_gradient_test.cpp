// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "splatting/distributed/sum_of_views.h"
#include "tests/splatting/train/synthetic_views.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

using test::SyntheticViews;

// Sums over the views of an iteration.
struct Learned {
  std::vector<float> gradient, pull;
  Index views = 0;  // observed by density control
  double objective = 0, values = 0;
  friend bool operator==(const Learned&, const Learned&) = default;
};

class ViewGradients : public testing::Test {
 protected:
  using Sum = SumOfViews<Host>;

  // All views share one gradient array, zeroed after each.
  static void Add(const SyntheticViews& all, int k, Sum& sum) {
    const SyntheticViews::View& view = all.views[static_cast<std::size_t>(k)];
    std::vector<float> gradient = view.gradient;
    sum.Add(k, view.pull_view(), gradient.data(), [&] { return view.cost; });
    EXPECT_EQ(gradient, std::vector<float>(gradient.size())) << "zeroed for the next view";
  }
  static Learned Finish(const SyntheticViews& all, Sum& sum, DensityControl<Host>& density) {
    Learned learned;
    learned.gradient.resize(all.views[0].gradient.size());
    const ViewCost cost = sum.Finish(learned.gradient.data());
    learned.pull = {density.pull().begin(), density.pull().end()};
    learned.views = density.views();
    learned.objective = cost.objective, learned.values = cost.values;
    density.ResetStatistics(all.gaussians());
    return learned;
  }
  static DensityControl<Host> ControlOf(const SyntheticViews& all) {
    DensityControl<Host> density({}, 1);
    density.ResetStatistics(all.gaussians());
    return density;
  }
  static Learned InOrder(const SyntheticViews& all, const std::vector<int>& order) {
    Sum sum;
    DensityControl<Host> density = ControlOf(all);
    sum.Begin(all.layout, static_cast<Index>(all.views.size()), &density);
    for (const int k : order) Add(all, k, sum);
    return Finish(all, sum, density);
  }
};

// The summation tree in plain loops over dense arrays.
Learned Plain(const SyntheticViews& all, std::size_t begin, std::size_t end) {
  if (end - begin == 1) {
    const SyntheticViews::View& view = all.views[begin];
    Learned one{.gradient = view.gradient, .pull = {}, .views = 1};
    one.objective = view.cost.objective, one.values = view.cost.values;
    for (Index i = 0; i < all.gaussians(); ++i) {
      one.pull.push_back(view.rank_of[static_cast<std::size_t>(i)] >= 0 ? view.pull_view().Of(i) : 0);
    }
    return one;
  }
  std::size_t half = 1;
  while (2 * half < end - begin) half *= 2;
  Learned left = Plain(all, begin, begin + half);
  const Learned right = Plain(all, begin + half, end);
  const auto add = [](auto& to, const auto& from) {
    for (std::size_t i = 0; i < to.size(); ++i) to[i] += from[i];
  };
  add(left.gradient, right.gradient), add(left.pull, right.pull);
  left.objective += right.objective, left.values += right.values, left.views += right.views;
  return left;
}

TEST_F(ViewGradients, AddUpAsTheTreeDoes) {
  for (const int count : {2, 3, 4, 5, 7}) {
    const SyntheticViews all(count);
    std::vector<int> order(static_cast<std::size_t>(count));
    std::iota(order.begin(), order.end(), 0);
    EXPECT_EQ(InOrder(all, order), Plain(all, 0, static_cast<std::size_t>(count))) << count;
  }
}

TEST_F(ViewGradients, TakeOnlyAttributesInUse) {
  const SyntheticViews all(3, splat::NumAttributes(1));
  EXPECT_EQ(InOrder(all, {0, 1, 2}), Plain(all, 0, 3));
}

TEST_F(ViewGradients, AreTheSameBitsInAnyOrder) {
  const SyntheticViews all(4);
  const Learned expected = InOrder(all, {0, 1, 2, 3});
  for (const std::vector<int>& order : {std::vector{3, 2, 1, 0}, {1, 2, 0, 3}, {2, 0, 3, 1}}) {
    EXPECT_EQ(InOrder(all, order), expected);
  }
  // Sequential addition would give other bits.
  Learned chain = Plain(all, 0, 1);
  for (std::size_t k = 1; k < 4; ++k) {
    const Learned next = Plain(all, k, k + 1);
    for (std::size_t i = 0; i < chain.gradient.size(); ++i) chain.gradient[i] += next.gradient[i];
  }
  EXPECT_NE(chain.gradient, expected.gradient);
}

std::vector<unsigned char> BytesOf(ViewGradient<Host>& term) {
  const HostSpan<const unsigned char> bytes = term.Bytes();
  return {bytes.begin(), bytes.end()};
}

// Two ranks with two views each exchange their sums as bytes.
TEST_F(ViewGradients, AreTheSameBitsInShares) {
  const SyntheticViews all(4);
  Sum whole;
  DensityControl<Host> density = ControlOf(all), elsewhere = ControlOf(all);
  whole.Begin(all.layout, 4, &density);
  for (const std::vector<int>& share : {std::vector{2, 3}, {0, 1}}) {
    Sum part;
    part.Begin(all.layout, 4, &elsewhere);
    for (const int k : share) Add(all, k, part);
    std::vector<Sum::Part> parts = part.TakeParts();
    ASSERT_EQ(parts.size(), 1u);
    const std::vector<unsigned char> sent = BytesOf(parts[0].second);
    whole.AddPart(parts[0].first, {sent.data(), static_cast<Index>(sent.size())});
  }
  EXPECT_EQ(Finish(all, whole, density), InOrder(all, {0, 1, 2, 3}));
}

// The sums are reused for successive iterations.
TEST_F(ViewGradients, LeaveNothingBehind) {
  const SyntheticViews first(5), then(3, splat::NumAttributes(2));
  Sum sum;
  DensityControl<Host> density = ControlOf(first);
  for (const SyntheticViews* all : {&first, &then}) {
    sum.Begin(all->layout, static_cast<Index>(all->views.size()), &density);
    for (int k = 0; k < static_cast<int>(all->views.size()); ++k) Add(*all, k, sum);
    EXPECT_EQ(Finish(*all, sum, density), Plain(*all, 0, all->views.size()));
  }
}

TEST_F(ViewGradients, HoldWhatIsSeen) {
  const SyntheticViews all(1);
  gs::ViewGradientPool<Host> terms;
  std::vector<float> gradient = all.views[0].gradient;
  ViewGradient<Host> term = terms.Extract(all.layout, all.views[0].pull_view(), true, gradient.data());
  EXPECT_EQ(term.blocks(), 3) << "of five blocks, two are not visible";
  EXPECT_LE(term.rows(), 3 * all.layout.MostRows());
  EXPECT_NEAR(static_cast<double>(BytesOf(term).size()), static_cast<double>(term.rows() * term::kLanes) * 4, 400);

  std::vector<std::int32_t> nothing(static_cast<std::size_t>(all.gaussians()), -1);
  density::PullView pull_view = all.views[0].pull_view();
  pull_view.rank_of = nothing.data();
  EXPECT_EQ(terms.Extract(all.layout, pull_view, true, gradient.data()).blocks(), 0);
}

TEST_F(ViewGradients, PullIsLeftOutWhereNobodyNeedsIt) {
  const SyntheticViews all(2);
  Sum sum;
  DensityControl<Host> density = ControlOf(all);
  sum.Begin(all.layout, 2, nullptr);
  for (int k = 0; k < 2; ++k) Add(all, k, sum);
  const Learned learned = Finish(all, sum, density);
  EXPECT_EQ(learned.pull, std::vector<float>(static_cast<std::size_t>(all.gaussians())));
  EXPECT_EQ(learned.views, 0);
  EXPECT_EQ(learned.gradient, InOrder(all, {0, 1}).gradient);
  // Nor does the term contain pulls.
  gs::ViewGradientPool<Host> terms;
  for (const bool needs_pull : {false, true}) {
    std::vector<float> gradient = all.views[0].gradient;
    ViewGradient<Host> term = terms.Extract(all.layout, all.views[0].pull_view(), needs_pull, gradient.data());
    std::vector<float> pull(learned.pull.size(), 0.0f);
    terms.AddPull(all.layout, term, pull.data());
    EXPECT_EQ(pull, needs_pull ? Plain(all, 0, 1).pull : learned.pull);
  }
}

// A single view is used in place, without addition.
TEST_F(ViewGradients, OfOneViewStayWhereTheyAre) {
  const SyntheticViews all(1);
  Sum sum;
  DensityControl<Host> density = ControlOf(all);
  std::vector<float> gradient = all.views[0].gradient;
  sum.Begin(all.layout, 1, &density);
  sum.Add(0, all.views[0].pull_view(), gradient.data(), [&] { return all.views[0].cost; });
  EXPECT_EQ(sum.Finish(gradient.data()).objective, all.views[0].cost.objective);
  EXPECT_EQ(gradient, all.views[0].gradient);
  EXPECT_EQ(std::vector<float>(density.pull().begin(), density.pull().end()), Plain(all, 0, 1).pull);
  EXPECT_EQ(density.views(), 1);
}

TEST_F(ViewGradients, BytesThatAreNoneAreRefused) {
  const SyntheticViews all(1);
  gs::ViewGradientPool<Host> terms;
  std::vector<float> gradient = all.views[0].gradient;
  ViewGradient<Host> term = terms.Extract(all.layout, all.views[0].pull_view(), true, gradient.data());
  const std::vector<unsigned char> bytes = BytesOf(term);
  const auto all_bytes = static_cast<Index>(bytes.size());
  ViewGradient<Host> received;
  received.Assign({bytes.data(), all_bytes});
  EXPECT_EQ(received.rows(), term.rows());
  for (const Index size : {Index{0}, Index{10}, all_bytes - 1}) {
    EXPECT_THAT([&] { received.Assign({bytes.data(), size}); }, ThrowsError(kUnavailable, std::to_string(size)));
  }
}

}  // namespace
}  // namespace vesta::gs
