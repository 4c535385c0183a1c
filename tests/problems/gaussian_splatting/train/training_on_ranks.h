// Trainings by several processes, which are threads of the test.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "problems/gaussian_splatting/model/view_owners.h"
#include "tests/problems/gaussian_splatting/train/training_scene.h"
#include "tests/support/thread_ranks.h"

namespace vesta::gs::test {

// With views that judge, evaluated once on the way.
inline TrainOptions TrainingOnRanks(int iterations, int lm_iterations) {
  TrainOptions options = ShortTraining(iterations, lm_iterations);
  options.adam.evaluations = 2;
  options.parsimony = ParsimonyOptions();
  options.adam.views_per_iteration = 3;
  return options;
}

// With Gaussians enough for three processes to have some of their own.
inline Scene SceneToDivide() { return TrainingScene(700); }
inline TrainOptions DividedTraining(int iterations, int lm_iterations) {
  TrainOptions options = TrainingOnRanks(iterations, lm_iterations);
  options.density.max_gaussians = 1000;
  return options;
}

// By all of them the same; of the first.
inline TrainResult TrainOn(int count, const Scene& scene, const TrainOptions& options,
                           const StageRunners& stages = HostStages()) {
  std::vector<TrainResult> all(static_cast<std::size_t>(count));
  vesta::test::OnThreadRanks(count, [&](Ranks& ranks) {
    TrainCallbacks callbacks;
    callbacks.ranks = &ranks;
    all[static_cast<std::size_t>(ranks.rank())] = Train(scene, options, 0, callbacks, stages);
  });
  for (const TrainResult& result : all) {
    EXPECT_EQ(result.model.data, all[0].model.data);
    EXPECT_EQ(result.history.back().test.psnr, all[0].history.back().test.psnr);
    EXPECT_EQ(result.history.back().cost, all[0].history.back().cost);
  }
  return std::move(all[0]);
}

// The photographs of a process, in a store that notes which were decoded.
class NotedPhotographs {
 public:
  // The scene as the process loads it.
  Scene Of(Scene scene, const Ranks& ranks) {
    is_own_ = OwnViewsOf(scene.views, &ranks);
    const double bytes = 3.0 * sizeof(float) * scene.views[0].camera.width * scene.views[0].camera.height;
    scene.photographs = std::make_shared<PhotographStore>(100 * bytes);
    for (std::size_t v = 0; v < scene.views.size(); ++v) {
      View& view = scene.views[v];
      const auto decode = [this, image = view.image, name = view.name] {
        const std::lock_guard lock(mutex_);
        decoded_.insert(name);
        return image;
      };
      view.stored = std::make_shared<const StoredPhotograph>(
          scene.photographs, PhotographSource{.decode = decode, .bytes = bytes, .work_bytes = 0, .is_own = is_own_[v]});
      view.image = Image();
    }
    return scene;
  }
  // Each of its own was decoded, and none of others.
  void ExpectOwnAlone(const Scene& scene) const {
    for (std::size_t v = 0; v < scene.views.size(); ++v) {
      EXPECT_EQ(decoded_.contains(scene.views[v].name), is_own_[v]) << scene.views[v].name;
    }
  }

 private:
  std::vector<bool> is_own_;
  std::mutex mutex_;
  std::set<std::string> decoded_;
};

// By processes that read their own photographs alone; of one that reads all.
inline TrainResult ExpectOwnPhotographsDo(int count, const Scene& scene, const TrainOptions& options,
                                          const StageRunners& stages = HostStages()) {
  TrainResult expected = TrainOn(1, scene, options, stages);
  std::vector<NotedPhotographs> photographs(static_cast<std::size_t>(count));
  vesta::test::OnThreadRanks(count, [&](Ranks& ranks) {
    const Scene own = photographs[static_cast<std::size_t>(ranks.rank())].Of(scene, ranks);
    TrainCallbacks callbacks;
    callbacks.ranks = &ranks;
    EXPECT_EQ(Train(own, options, 0, callbacks, stages).model.data, expected.model.data);
  });
  for (const NotedPhotographs& of_rank : photographs) of_rank.ExpectOwnAlone(scene);
  return expected;
}

}  // namespace vesta::gs::test
