// Trainings by several processes, which are threads of this one. Label threads: run under the thread sanitizer too.
#include <gtest/gtest.h>

#include "tests/problems/gaussian_splatting/train/training_on_ranks.h"

namespace vesta::gs {
namespace {

using test::TrainOn;

// Both stages.
TrainOptions Options() { return test::TrainingOnRanks(60, 2); }

TEST(TrainingOverRanks, ComesToTheSameBitsForAnyNumberOfThem) {
  const Scene scene = test::TrainingScene();
  const TrainOptions options = Options();
  const TrainResult alone = TrainOn(1, scene, options);
  test::ExpectLastRowIsOf(alone, scene, options.background);
  for (const int count : {2, 3}) {
    const TrainResult together = TrainOn(count, scene, options);
    EXPECT_EQ(together.model.data, alone.model.data) << count;
    EXPECT_EQ(together.history.back().cost, alone.history.back().cost);
  }
}

TEST(TrainingOverRanks, AdamsStageIsThatOfAProcessAlone) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = Options();
  options.lm.iterations = 0;
  EXPECT_EQ(TrainOn(3, scene, options).model.data, Train(scene, options, 0, {}).model.data);
  options.adam.views_per_iteration = 1;
  EXPECT_EQ(TrainOn(2, scene, options).model.data, Train(scene, options, 0, {}).model.data);
}

TEST(TrainingOverRanks, EndsWhereTheViewsHeldOutAreGoodEnough) {
  Scene scene = test::TrainingScene();
  HoldOut(&scene.views);
  TrainOptions options = Options();
  options.target_psnr = 5;
  const TrainResult result = TrainOn(2, scene, options);
  EXPECT_GE(result.history.back().held_out.psnr, 5);
  EXPECT_LT(result.history.back().iteration, 20);
}

TEST(TrainingOverRanks, LooksAtNoPhotographOfOthers) { test::ExpectOwnPhotographsDo(3, Options()); }

}  // namespace
}  // namespace vesta::gs
