// Trainings by several processes, which are threads of this one. Label threads: run under the thread sanitizer too.
#include <gtest/gtest.h>

#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/model/view_owners.h"
#include "tests/problems/gaussian_splatting/train/training_scene.h"
#include "tests/support/thread_ranks.h"

namespace vesta::gs {
namespace {

// Both stages, with views that judge.
TrainOptions Options() {
  TrainOptions options = test::ShortTraining(60, 2);
  options.parsimony = ParsimonyOptions();
  options.adam.views_per_iteration = 3;
  return options;
}

// By all of them the same; of the first.
TrainResult TrainOn(int count, const Scene& scene, const TrainOptions& options) {
  TrainResult first;
  std::vector<TrainResult> all(static_cast<std::size_t>(count));
  vesta::test::OnThreadRanks(count, [&](Ranks& ranks) {
    TrainCallbacks callbacks;
    callbacks.ranks = &ranks;
    all[static_cast<std::size_t>(ranks.rank())] = Train(scene, options, 0, callbacks);
  });
  for (const TrainResult& result : all) {
    EXPECT_EQ(result.model.data, all[0].model.data);
    EXPECT_EQ(result.history.back().test.psnr, all[0].history.back().test.psnr);
    EXPECT_EQ(result.history.back().cost, all[0].history.back().cost);
  }
  return std::move(all[0]);
}

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

// The scene as a process loads it: photographs in a store that notes which were decoded.
Scene Noting(Scene scene, const Ranks& ranks, std::mutex* mutex, std::set<std::string>* decoded) {
  const std::vector<bool> is_own = OwnViewsOf(scene.views, &ranks);
  const double bytes = 3.0 * sizeof(float) * scene.views[0].camera.width * scene.views[0].camera.height;
  scene.photographs = std::make_shared<PhotographStore>(100 * bytes);
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    View& view = scene.views[v];
    const auto decode = [image = view.image, name = view.name, mutex, decoded] {
      const std::lock_guard lock(*mutex);
      decoded->insert(name);
      return image;
    };
    view.stored = std::make_shared<const StoredPhotograph>(
        scene.photographs, PhotographSource{.decode = decode, .bytes = bytes, .work_bytes = 0, .is_own = is_own[v]});
    view.image = Image();
  }
  return scene;
}

TEST(TrainingOverRanks, LooksAtNoPhotographOfOthers) {
  constexpr int kRanks = 3;
  const Scene scene = test::TrainingScene();
  const TrainOptions options = Options();
  const TrainResult expected = TrainOn(1, scene, options);
  std::mutex mutexes[kRanks];
  std::set<std::string> decoded[kRanks];
  vesta::test::OnThreadRanks(kRanks, [&](Ranks& ranks) {
    const Scene own = Noting(scene, ranks, &mutexes[ranks.rank()], &decoded[ranks.rank()]);
    TrainCallbacks callbacks;
    callbacks.ranks = &ranks;
    EXPECT_EQ(Train(own, options, 0, callbacks).model.data, expected.model.data);
  });
  for (int r = 0; r < kRanks; ++r) {
    const std::vector<bool> is_own = OwnViewsOf(scene.views, kRanks, r);
    for (std::size_t v = 0; v < scene.views.size(); ++v) {
      EXPECT_EQ(decoded[r].contains(scene.views[v].name), is_own[v]) << scene.views[v].name << ", process " << r;
    }
  }
}

}  // namespace
}  // namespace vesta::gs
