#include "problems/gaussian_splatting/train/early_end.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>

#include "problems/gaussian_splatting/train/session.h"
#include "tests/problems/gaussian_splatting/train/training_scene.h"

namespace vesta::gs {
namespace {

using test::TrainingScene;

// Evaluation is part of the time, and so is what is foreseen of it.
TEST(EarlyEnd, TimeLimitIsOfAllTime) {
  const Scene scene = TrainingScene();
  TrainOptions options;
  options.time_limit = 100;
  const TrainCallbacks callbacks;
  TrainingSession session(scene, options, 50, callbacks);
  EXPECT_FALSE(session.early_end().ShouldStop(10));
  EXPECT_TRUE(session.early_end().HasTimeToRecord(2));
  EXPECT_FALSE(session.early_end().HasTimeToRecord(5)) << "a twentieth, of 55";
  EXPECT_TRUE(session.early_end().ShouldStop(60));
  EXPECT_TRUE(session.early_end().ShouldStop()) << "once and for all";
  // Half of what training on as many pixels takes, until one has been measured.
  EXPECT_DOUBLE_EQ(session.history().SecondsAhead(1e-3), 0.5e-3 * 12 * 40 * 30);

  TrainingSession evaluating(scene, options, 99.999, callbacks);
  evaluating.history().Record(Stage::kAdam, 1,
                              {0,
                               [] {
                                 ::usleep(2000);
                                 return Evaluation();
                               },
                               {}});
  EXPECT_GE(evaluating.history().SecondsAhead(0), 0.002);
  EXPECT_LT(evaluating.history().SecondsAhead(1e3), 1e3) << "measured";
  EXPECT_GE(evaluating.clock().Total(), 100);
  EXPECT_TRUE(evaluating.early_end().ShouldStop());
  options.time_limit = 0;
  TrainingSession unlimited(scene, options, 1e6, callbacks);
  EXPECT_FALSE(unlimited.early_end().ShouldStop(1e6));
  EXPECT_TRUE(unlimited.early_end().HasTimeToRecord(1e6));
}

// Room to write is kept, and a quarter for LM where it is asked for.
TEST(EarlyEnd, AdamHasTheTimeThatOthersLeave) {
  const Scene scene = TrainingScene();
  const TrainCallbacks callbacks;
  TrainOptions options;
  const auto seconds = [&] { return TrainingSession(scene, options, 50, callbacks).early_end().SecondsForAdam(); };
  EXPECT_TRUE(std::isinf(seconds()));
  options.time_limit = 100;
  const double alone = seconds();
  EXPECT_LT(alone, 50);
  EXPECT_GT(alone, 47);
  options.lm.iterations = 1;
  EXPECT_NEAR(seconds(), alone - 25, 1);
}

}  // namespace
}  // namespace vesta::gs
