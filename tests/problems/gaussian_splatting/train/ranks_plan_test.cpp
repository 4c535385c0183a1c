// What several processes plan, of memory and time; they are threads of this one.
#include <gtest/gtest.h>

#include <vector>

#include "problems/gaussian_splatting/train/over_ranks.h"
#include "tests/problems/gaussian_splatting/train/training_on_ranks.h"

namespace vesta::gs {
namespace {

using test::TrainOn;

// By the same views on all of them, and by no more than a process holds.
TEST(TrainingOverRanks, PlansByTheLargestShare) {
  Scene scene = test::TrainingScene();
  std::vector<const View*> views;
  for (View& view : scene.views) views.push_back(&view);
  for (std::size_t v = 8; v < views.size(); ++v) scene.views[v].camera.width = 80;  // the last of three holds the most
  vesta::test::OnThreadRanks(3, [&](Ranks& ranks) {
    const Share last = ViewsOfProcess(static_cast<Index>(views.size()), 3, 2);
    EXPECT_EQ(LargestShare(views, &ranks), (std::vector<const View*>(views.begin() + last.begin, views.end())));
  });
  EXPECT_EQ(LargestShare(views, nullptr), views);
}

// Though all train on each view, LM has a share of them in each: of two processes half of what takes the most.
TEST(TrainingOverRanks, LmIsPlannedByItsOwnShare) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = test::TrainingOnRanks(60, 2);
  options.adam.views_per_iteration = 1;
  options.lm.jacobian = JacobianKind::kCache32;
  options.lm.iterations = 1;
  const double one = TrainOn(1, scene, options).memory.predicted_mib,
               two = TrainOn(2, scene, options).memory.predicted_mib;
  EXPECT_LT(two, 0.75 * one);
}

// Whichever of them holds more before they begin: it is the most that they plan by.
TEST(TrainingOverRanks, ABudgetBindsAllAlike) {
  const Scene scene = test::SceneToDivide();
  TrainOptions options = test::DividedTraining(60, 1);
  const auto train = [&](double budget_gib, double of_second) {
    std::vector<TrainResult> all(2);
    options.memory.budget_gib = budget_gib;
    vesta::test::OnThreadRanks(2, [&](Ranks& ranks) {
      TrainOptions own = options;
      own.memory.before_mib = ranks.rank() == 0 ? 10 : of_second;
      TrainCallbacks callbacks;
      callbacks.ranks = &ranks;
      all[static_cast<std::size_t>(ranks.rank())] = Train(scene, own, 0, callbacks);
    });
    EXPECT_EQ(all[0].model.data, all[1].model.data);
    EXPECT_EQ(all[0].memory.predicted_mib, all[1].memory.predicted_mib);
    return std::move(all[0]);
  };
  const TrainResult free = train(0, 10), other = train(0, 15);
  EXPECT_NEAR(other.memory.predicted_mib, free.memory.predicted_mib + 5, 1e-6);
  EXPECT_EQ(other.model.data, free.model.data);
  // Room for all, for fewer, and for not even those that there are at first.
  EXPECT_EQ(train(18. / 1024, 10).model.data, free.model.data);
  EXPECT_NE(train(18. / 1024, 13.5).model.data, free.model.data);
  EXPECT_EQ(train(14.5 / 1024, 10).model.data, train(18. / 1024, 13.5).model.data);
  EXPECT_THROW(train(18. / 1024, 15), Error);
}

// However different their clocks: one is slow, and the first one's counts.
TEST(TrainingOverRanks, EndsTogetherWhereTimeIsLimited) {
  const Scene scene = test::TrainingScene();
  for (const int lm_iterations : {0, 2}) {
    TrainOptions options = test::TrainingOnRanks(1000000, lm_iterations);
    options.time_limit = 0.5;
    std::vector<TrainResult> all(2);
    vesta::test::OnThreadRanks(2, [&](Ranks& ranks) {
      TrainCallbacks callbacks;
      callbacks.ranks = &ranks;
      all[static_cast<std::size_t>(ranks.rank())] = Train(scene, options, ranks.rank() == 1 ? -100 : 0, callbacks);
    });
    EXPECT_EQ(all[0].model.data, all[1].model.data);
    EXPECT_LT(all[0].history.back().iteration, 100000);
    EXPECT_EQ(all[0].history.size(), all[1].history.size());
    EXPECT_EQ(all[0].history.back().stage, lm_iterations > 0 ? Stage::kLm : Stage::kAdam);
  }
}

}  // namespace
}  // namespace vesta::gs
