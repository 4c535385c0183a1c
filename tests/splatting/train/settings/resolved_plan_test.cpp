// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "splatting/train/settings/training_plan.h"

namespace vesta::gs {
namespace {

TEST(FitToScene, GivesManyViewsMoreIterations) {
  EXPECT_EQ(IterationsFor(1), 4000);
  EXPECT_EQ(IterationsFor(20), 4000);
  EXPECT_EQ(IterationsFor(264), 20064);
  TrainOptions options = PresetOptions("balanced");
  EXPECT_EQ(FitToScene(options, 264).adam.iterations, 20064);
  options.adam.length = 0.25;
  EXPECT_EQ(FitToScene(options, 264).adam.iterations, 5016);
  options.adam.views_per_iteration = 4;
  EXPECT_EQ(FitToScene(options, 264).adam.iterations, 5016) << "counted in views";
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
