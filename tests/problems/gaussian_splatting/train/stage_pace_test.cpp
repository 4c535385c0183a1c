#include "problems/gaussian_splatting/train/stage_pace.h"

#include <gtest/gtest.h>

#include "problems/gaussian_splatting/train/fit_to_scene.h"

namespace vesta::gs {
namespace {

TEST(StagePace, FirstIterationsDoNotCount) {
  StagePace pace;
  EXPECT_FALSE(pace.is_known());
  pace.Observe(true, 10);
  EXPECT_FALSE(pace.is_known());
  pace.Observe(true, 0.1);
  EXPECT_TRUE(pace.is_known());
  EXPECT_DOUBLE_EQ(pace.Seconds(true), 0.1);
  EXPECT_GT(pace.Seconds(false), 0.2) << "foreseen";
  pace.Observe(false, 10);
  pace.Observe(false, 0.4);
  EXPECT_DOUBLE_EQ(pace.Seconds(false), 0.4) << "measured";
}

TEST(StagePace, FollowsIterationsThatBecomeSlower) {
  StagePace pace;
  for (int it = 0; it < 100; ++it) pace.Observe(false, 0.1);
  for (int it = 0; it < 100; ++it) pace.Observe(false, 0.3);
  EXPECT_NEAR(pace.Seconds(false), 0.3, 0.002);
}

// A clock by hand: iterations of half size take 1, those of full size 3, later 5. The stage ends when time does, and
// as large a part of it is coarse as was asked for.
TEST(StagePace, EndsTheStageInTime) {
  constexpr double kTime = 5000, kCoarse = 0.5;
  StagePace pace;
  double clock = 0, done = 0;
  int coarse = 0, fine = 0;
  while (done < 1) {
    const double left = pace.is_known() ? pace.IterationsLeft(kTime - clock, done, kCoarse) : 1e300;
    done += (1 - done) / std::max(1.0, left);
    const bool is_coarse = done <= kCoarse;
    ++(is_coarse ? coarse : fine);
    const double seconds = is_coarse ? 1 : fine < 500 ? 3 : 5;
    pace.Observe(is_coarse, seconds);
    clock += seconds;
    ASSERT_LT(clock, 2 * kTime);
  }
  EXPECT_NEAR(clock, kTime, 6);
  EXPECT_GT(coarse, 900);
  EXPECT_GT(fine, 600);
}

TEST(FitToScene, GivesManyViewsMoreIterations) {
  EXPECT_EQ(IterationsFor(1), 4000);
  EXPECT_EQ(IterationsFor(20), 4000);
  EXPECT_EQ(IterationsFor(264), 20064);
  TrainOptions options = PresetOptions("balanced");
  EXPECT_EQ(FitToScene(options, 264).adam.iterations, 20064);
  options.adam.length = 0.25;
  EXPECT_EQ(FitToScene(options, 264).adam.iterations, 5016);
  options.adam.views_per_iteration = 4;
  EXPECT_EQ(FitToScene(options, 264).adam.iterations, 1254);
  options.adam.iterations = 7;
  EXPECT_EQ(FitToScene(options, 264).adam.iterations, 7);
  options.adam.iterations.reset();
  options.time_limit = 60;
  EXPECT_EQ(FitToScene(options, 264).adam.iterations, 10000000) << "time ends it";
  EXPECT_EQ(FitToScene(options, 20).sh_degree, 2);
  EXPECT_EQ(FitToScene(options, 264).sh_degree, 3);
}

}  // namespace
}  // namespace vesta::gs
