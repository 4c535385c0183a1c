// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "splatting/adam/adam_options.h"
#include "splatting/adam/view_order.h"
#include "splatting/density/density_options.h"

namespace vesta::gs {
namespace {

// The span of iteration `it` of n.
StageSpan Span(int it, int n = 100) { return {(it - 1.0) / n, 1.0 * it / n}; }

TEST(AdamSchedule, RatesDecayGeometrically) {
  const AdamOptions adam{.lr_scale = 5, .lr_final_ratio = 0.25};
  EXPECT_DOUBLE_EQ(RateFactor(adam, Span(1)), 5);
  EXPECT_DOUBLE_EQ(RateFactor(adam, Span(51)), 2.5);
  EXPECT_DOUBLE_EQ(RateFactor(adam, Span(101)), 1.25);
}

TEST(AdamSchedule, TheMeanIsOverTheLastPart) {
  const AdamOptions adam{.averaging_fraction = 0.3};
  EXPECT_FALSE(Averages(adam, Span(70), 70));
  EXPECT_TRUE(Averages(adam, Span(75), 75));
  EXPECT_FALSE(Averages(adam, Span(76), 76));
  EXPECT_TRUE(Averages(adam, {0.98, 1}, 88)) << "always in the last iteration";
  AdamOptions of_several = adam;
  of_several.batch_size = 2;
  EXPECT_TRUE(Averages(of_several, Span(76), 76)) << "every other iteration";
  EXPECT_FALSE(Averages(of_several, Span(75), 75));
  of_several.batch_size = 8;
  EXPECT_TRUE(Averages(of_several, Span(77), 77));
  EXPECT_FALSE(Averages({.averaging_fraction = 0}, Span(100), 100));
}

TEST(AdamSchedule, CoarseViewsComeFirst) {
  const AdamOptions adam{.half_resolution_until = 0.3};
  EXPECT_TRUE(IsCoarse(adam, Span(1)));
  EXPECT_TRUE(IsCoarse(adam, Span(30)));
  EXPECT_FALSE(IsCoarse(adam, Span(31)));
  EXPECT_FALSE(IsCoarse({.half_resolution_until = 0}, Span(1)));
}

TEST(AdamSchedule, BandsComeOneByOne) {
  EXPECT_EQ(ActiveShDegree(0.08, 3, Span(8)), 0);
  EXPECT_EQ(ActiveShDegree(0.08, 3, Span(9)), 1);
  EXPECT_EQ(ActiveShDegree(0.08, 3, Span(25)), 3);
  EXPECT_EQ(ActiveShDegree(0.08, 2, Span(99)), 2);
  EXPECT_EQ(ActiveShDegree(0, 3, Span(1)), 3);
}

// Each multiple of a fraction is crossed once, for any number of iterations and uneven steps.
TEST(StageSpan, ReachesEachPartOnce) {
  for (const int n : {20, 100, 137, 4000}) {
    int times = 0;
    for (int it = 1; it <= n; ++it) times += Span(it, n).CrossesMultipleOf(0.05);
    EXPECT_EQ(times, 20) << n;
  }
  int times = 0;
  for (double done = 0; done < 1;) {
    const double next = std::min(1.0, done + 0.001 + 0.03 * done);
    times += StageSpan{done, next}.CrossesMultipleOf(0.05);
    done = next;
  }
  EXPECT_EQ(times, 20);
  EXPECT_FALSE(Span(50).CrossesMultipleOf(0));
}

TEST(StageSpan, CountsOfTinyPartsAreNumbers) {
  EXPECT_EQ((StageSpan{0.5, 0.6}.PartsBefore(0.1)), 5);
  EXPECT_GE((StageSpan{0.5, 0.6}.PartsBefore(1e-300)), 1000000);
}

TEST(DensitySchedule, IsOfTheMiddleOfTheStage) {
  const DensityOptions density{.begin = 0.1, .end = 0.6, .every = 0.05, .opacity_reset_every = 0.3};
  int times = 0, first = 0, last = 0;
  for (int it = 1; it <= 4000; ++it) {
    if (!Densifies(density, Span(it, 4000))) continue;
    ++times, last = it;
    if (first == 0) first = it;
  }
  EXPECT_EQ(times, 11);
  EXPECT_EQ(first, 400);
  EXPECT_EQ(last, 2400);
  EXPECT_TRUE(Observes(density, Span(60)));
  EXPECT_FALSE(Observes(density, Span(61)));
  EXPECT_TRUE(ResetsOpacity(density, Span(30)));
  EXPECT_FALSE(ResetsOpacity(density, Span(31)));
  EXPECT_FALSE(Densifies({.enabled = false}, Span(30)));
}

TEST(AdamSchedule, EveryViewOnceAnEpoch) {
  ViewOrder order(5, 3);
  for (int epoch = 0; epoch < 4; ++epoch) {
    std::vector<int> times(5, 0);
    for (int k = 0; k < 5; ++k) ++times[order.Next()];
    EXPECT_EQ(times, std::vector<int>(5, 1));
  }
}

TEST(AdamSchedule, AnIterationTakesItsViewsFromDifferentRuns) {
  constexpr std::size_t kViews = 10, kAtOnce = 3;  // runs of 3, 3 and 4
  ViewOrder order(kViews, 3, kAtOnce);
  std::vector<int> times(kViews, 0);
  for (int k = 0; k < 12; ++k) {
    for (const std::size_t end : {3, 6, 10}) {
      const std::size_t view = order.Next();
      EXPECT_LT(view, end);
      EXPECT_GE(view, end == 10 ? 6 : end - 3);
      ++times[view];
    }
  }
  EXPECT_EQ(times, (std::vector<int>{4, 4, 4, 4, 4, 4, 3, 3, 3, 3}));
  ViewOrder few(2, 3, kAtOnce);
  EXPECT_NE(few.Next(), few.Next());
}

}  // namespace
}  // namespace vesta::gs
