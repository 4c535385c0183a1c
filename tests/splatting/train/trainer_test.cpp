// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/trainer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "kernels/core/check.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/model/initialize.h"
#include "splatting/evaluate/evaluation.h"
#include "tests/splatting/train/is_note.h"
#include "tests/splatting/train/training_scene.h"

namespace vesta::gs {
namespace {

using test::ExpectLastRowIsOf;
using test::ShortTraining;
using test::TrainingScene;

void ExpectUsable(const SplatModel& model) {
  ASSERT_GT(model.count, 0);
  ASSERT_EQ(static_cast<Index>(model.data.size()), model.num_attributes() * model.count);
  for (const float value : model.data) ASSERT_TRUE(std::isfinite(value));
}

// Cut-out photographs, rendered over black, and their alpha.
Scene CutOutScene() {
  Scene scene = TrainingScene();
  const SplatModel object = test::RandomModel(60, 1, 7);
  Renderer over_black({0, 0, 0}, NearPlane(scene)), over_white({1, 1, 1}, NearPlane(scene));
  for (View& view : scene.views) {
    view.image = over_black.Render(object, view);
    const Image white = over_white.Render(object, view);
    for (std::size_t i = 0; i < white.num_pixels(); ++i) {
      view.image.transparency.push_back(white.plane(0)[i] - view.image.plane(0)[i]);
    }
  }
  return scene;
}

// Over white, the photographs are those over black plus the transparency.
double PsnrOverWhite(const SplatModel& model, Scene scene) {
  for (View& view : scene.views) {
    for (int c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < view.image.num_pixels(); ++i) view.image.plane(c)[i] += view.image.transparency[i];
    }
  }
  return Renderer({1, 1, 1}, NearPlane(scene)).Evaluate(model, scene).test.psnr;
}

TEST(RandomBackground, KeepsCutOutObjectsTransparent) {
  const Scene scene = CutOutScene();
  TrainOptions options = ShortTraining(250, 0);
  const TrainResult random = Train(scene, options, {}, {});
  options.random_background = false;
  const TrainResult fixed = Train(scene, options, {}, {});
  EXPECT_GT(PsnrOverWhite(random.model, scene), PsnrOverWhite(fixed.model, scene) + 3);
  // Photographs without transparency have one background.
  options.random_background = true;
  Scene opaque = scene;
  for (View& view : opaque.views) view.image.transparency.clear();
  EXPECT_EQ(Train(opaque, options, {}, {}).model.data, fixed.model.data);
}

// One training, shared by several tests.
class FullTraining : public testing::Test {
 protected:
  static constexpr int kAdam = 250, kLm = 6;
  struct Run {
    Scene scene = TrainingScene();
    std::vector<TrainProgress> reports;
    std::size_t evaluations = 0;
    TrainResult result;

    Run() {
      TrainCallbacks callbacks;
      callbacks.progress = [&](const TrainProgress& progress) { reports.push_back(progress); };
      callbacks.evaluated = [&](const HistoryRow& row, const splat::Model<float>& model) {
        ++evaluations;
        EXPECT_EQ(model.count, row.gaussians);
      };
      result = Train(scene, ShortTraining(kAdam, kLm), {.seconds = 1.5}, callbacks);
    }
  };
  std::vector<HistoryRow> Rows(Stage stage) const {
    std::vector<HistoryRow> rows;
    std::ranges::copy_if(run_.result.history, std::back_inserter(rows),
                         [&](const HistoryRow& row) { return row.stage == stage; });
    return rows;
  }
  static const Run& Once() {
    static const Run run;
    return run;
  }

  const Run& run_ = Once();
};

TEST_F(FullTraining, AdamImprovesByDecibels) {
  const SplatModel start = InitializeFromPoints(run_.scene.points, run_.scene.extent, 1, 100);
  Renderer renderer({0, 0, 0}, NearPlane(run_.scene));
  const Evaluation before = renderer.Evaluate(start, run_.scene);
  const HistoryRow after = Rows(Stage::kAdam).back();
  EXPECT_GT(after.train.psnr, before.train.psnr + 5);
  EXPECT_GT(after.test.psnr, before.test.psnr + 5);
  EXPECT_LT(after.cost, before.cost / 2);
  EXPECT_GT(run_.result.model.count, start.count) << "densification added no Gaussian";
  EXPECT_LE(run_.result.model.count, 100);
}

TEST_F(FullTraining, LmLowersTheCost) {
  const std::vector<HistoryRow> rows = Rows(Stage::kLm);
  ASSERT_EQ(rows.size(), 1u + kLm);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].iteration, static_cast<int>(i));
    EXPECT_LE(rows[i].cost, rows[i - 1].cost) << i;
  }
  EXPECT_LT(rows.back().cost, 0.9 * rows.front().cost);
  EXPECT_GE(rows.back().train.psnr, rows.front().train.psnr);
  EXPECT_FALSE(run_.result.lm_report.empty());
}

TEST_F(FullTraining, LmStartsWhereAdamStopped) {
  const HistoryRow adam = Rows(Stage::kAdam).back(), lm = Rows(Stage::kLm).front();
  EXPECT_EQ(adam.iteration, kAdam);
  EXPECT_EQ(lm.iteration, 0);
  EXPECT_EQ(lm.cost, adam.cost);
  EXPECT_EQ(lm.train.psnr, adam.train.psnr);
  EXPECT_EQ(lm.test.ssim, adam.test.ssim);
  EXPECT_EQ(lm.gaussians, adam.gaussians);
}

TEST_F(FullTraining, HistoryHasARowEveryTwentiethOfTheRun) {
  int previous = 0;
  for (const HistoryRow& row : Rows(Stage::kAdam)) {
    EXPECT_NEAR(row.iteration - previous, kAdam / 20.0, 1);
    EXPECT_EQ(row.train.views, 10);
    EXPECT_EQ(row.test.views, 2);
    previous = row.iteration;
  }
  double seconds = 1.5;
  for (const HistoryRow& row : run_.result.history) {
    EXPECT_GE(row.seconds, seconds);
    seconds = row.seconds;
  }
  EXPECT_EQ(run_.evaluations, run_.result.history.size());
  EXPECT_GE(run_.result.adam_seconds, 0);
  EXPECT_GE(run_.result.lm_seconds, 0);
  EXPECT_GT(run_.result.eval_seconds, 0);
}

TEST_F(FullTraining, ReportsEveryIteration) {
  ASSERT_EQ(run_.reports.size(), static_cast<std::size_t>(kAdam + kLm));
  for (std::size_t i = 0; i < run_.reports.size(); ++i) {
    const TrainProgress& report = run_.reports[i];
    const bool is_adam = i < kAdam;
    EXPECT_EQ(report.stage, is_adam ? Stage::kAdam : Stage::kLm);
    EXPECT_EQ(report.iteration, static_cast<int>(is_adam ? i + 1 : i + 1 - kAdam));
    EXPECT_EQ(report.iterations, is_adam ? kAdam : kLm);
    EXPECT_TRUE(std::isfinite(report.cost) && report.cost > 0);
    EXPECT_EQ(report.note.empty(), is_adam);
  }
}

TEST_F(FullTraining, ResultIsTheLastState) {
  ExpectUsable(run_.result.model);
  EXPECT_FALSE(run_.result.stopped);
  EXPECT_TRUE(run_.result.model.has_background);
  EXPECT_EQ(run_.result.model.sh_degree, 1);
  ExpectLastRowIsOf(run_.result, run_.scene, {0, 0, 0});
}

// Each LM option lowers the cost of a half-trained model.
TEST(Trainer, EveryLmVariantDescends) {
  const Scene scene = TrainingScene();
  const SplatModel start = Train(scene, ShortTraining(80, 0), {}, {}).model;
  const auto check = [&](const char* name, const auto& change) {
    SCOPED_TRACE(name);
    TrainOptions options = ShortTraining(0, 3);
    change(options.lm);
    const TrainResult result = Refine(scene, start, options, {}, {});
    ASSERT_GE(result.history.size(), 2u);
    EXPECT_LT(result.history.back().cost, 0.97 * result.history.front().cost) << result.lm_report;
    ExpectLastRowIsOf(result, scene, {0, 0, 0});
  };
  for (const StepRule rule : {StepRule::kCeres, StepRule::k3dgsLmV2, StepRule::k3dgsLmCode}) {
    check(ToString(rule), [&](LmStageOptions& lm) { lm.damping_update = rule; });
  }
  // Scaled by diag(J^T J), so λ starts where 3DGS-LM starts.
  check("diag", [](LmStageOptions& lm) { lm.damping = LmDamping::kDiagonal, lm.initial_lambda = 1; });
  check("jacobi", [](LmStageOptions& lm) { lm.preconditioner = LmPreconditioner::kJacobi; });
  check("line search", [](LmStageOptions& lm) { lm.line_search = true; });
  check("batches", [](LmStageOptions& lm) { lm.batches = 4; });
  check("merged batches", [](LmStageOptions& lm) { lm.batches = 4, lm.merge_batches = true, lm.line_search = true; });
  check("more batches than views", [](LmStageOptions& lm) { lm.batches = 1000; });
}

// Test images are only evaluated.
TEST(Trainer, TestImagesDoNotChangeTheModel) {
  const TrainOptions options = ShortTraining(40, 2);
  Scene scene = TrainingScene();
  const TrainResult before = Train(scene, options, {}, {});
  for (View& view : scene.views) {
    if (!view.is_test()) continue;
    for (float& value : view.image.rgb) value = 1 - value;
  }
  const TrainResult after = Train(scene, options, {}, {});
  EXPECT_EQ(after.model.data, before.model.data);
  EXPECT_EQ(after.history.back().train.psnr, before.history.back().train.psnr);
  EXPECT_NE(after.history.back().test.psnr, before.history.back().test.psnr);

  scene.views[3].image.rgb[17] += 0.5f;
  ASSERT_FALSE(scene.views[3].is_test());
  EXPECT_NE(Train(scene, options, {}, {}).model.data, before.model.data);
}

TEST(Trainer, SeedDecidesTheModel) {
  const Scene scene = TrainingScene();
  TrainOptions options = ShortTraining(40, 0);
  const SplatModel one = Train(scene, options, {}, {}).model;
  EXPECT_EQ(Train(scene, options, {}, {}).model.data, one.data);
  options.seed = 4;
  EXPECT_NE(Train(scene, options, {}, {}).model.data, one.data);
}

// With both training views in each iteration, their order, and so the seed, has no effect.
TEST(Trainer, ViewsOfAnIterationCountAlike) {
  Scene scene = TrainingScene();
  scene.views.resize(3);  // view 0 is a test view
  TrainOptions options = ShortTraining(20, 0);
  options.density.enabled = false;
  const auto model = [&](std::uint64_t seed, int views) {
    options.seed = seed;
    options.adam.batch_size = views;
    return Train(scene, options, {}, {}).model.data;
  };
  EXPECT_NE(model(3, 1), model(4, 1));
  EXPECT_EQ(model(3, 2), model(4, 2));
  EXPECT_NE(model(3, 2), model(3, 1));
}

TEST(Trainer, AsManyRowsAsAskedFor) {
  const Scene scene = TrainingScene();
  TrainOptions options = ShortTraining(40, 0);
  options.adam.evaluations = 4;
  const TrainResult result = Train(scene, options, {}, {});
  ASSERT_EQ(result.history.size(), 4u);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(result.history[static_cast<std::size_t>(i)].iteration, 10 * (i + 1));
}

// New halves render badly for some iterations, so rows precede densification.
TEST(Trainer, RowsOfTheHistoryAreOfBeforeDensification) {
  TrainOptions options = ShortTraining(40, 0);
  options.adam.evaluations = 2;
  options.density.every = 0.5;
  options.density.grow_pull = 0;
  const std::vector<HistoryRow> history = Train(TrainingScene(), options, {}, {}).history;
  ASSERT_EQ(history.size(), 2u);
  EXPECT_EQ(history[0].gaussians, TrainingScene().points.size());
  EXPECT_GT(history[1].gaussians, history[0].gaussians);
}

TEST(Trainer, StopEndsEarlyWithAModel) {
  const Scene scene = TrainingScene();
  constexpr int kAdam = 30;
  for (const int stop_after : {1, 10, kAdam, kAdam + 1, kAdam + 2}) {
    SCOPED_TRACE(stop_after);
    int reports = 0;
    TrainCallbacks callbacks;
    callbacks.progress = [&](const TrainProgress&) { ++reports; };
    // Adam calls `stop` before it reports an iteration, LM after.
    callbacks.stop = [&] { return reports >= stop_after; };
    const TrainResult result = Train(scene, ShortTraining(kAdam, 5), {}, callbacks);
    EXPECT_TRUE(result.stopped);
    EXPECT_GE(reports, stop_after);
    EXPECT_LE(reports, stop_after + 1);
    ExpectUsable(result.model);
    ExpectLastRowIsOf(result, scene, {0, 0, 0});
  }
}

TEST(Trainer, AdamsResultIsHandedOutBeforeLm) {
  const Scene scene = TrainingScene();
  SplatModel handed_out;
  TrainCallbacks callbacks;
  callbacks.before_lm = [&](const SplatModel& model) { handed_out = model; };
  TrainOptions options = ShortTraining(30, 1);
  options.background = {0.25, 0.5, 1};
  Train(scene, options, {}, callbacks);
  TrainOptions adam_alone = options;
  adam_alone.lm.iterations = 0;
  EXPECT_EQ(handed_out.data, Train(scene, adam_alone, {}, {}).model.data);
  EXPECT_EQ(handed_out.background[0], 0.25f);
  // If it throws, LM is skipped and Adam's result returned.
  callbacks.before_lm = [](const SplatModel&) { throw Error(kOutOfMemory, "no room"); };
  const TrainResult result = Train(scene, options, {}, callbacks);
  EXPECT_EQ(result.lm_left_out, "no room");
  EXPECT_EQ(result.history.back().stage, Stage::kAdam);
  EXPECT_EQ(result.model.data, handed_out.data);
  // Not called without LM.
  EXPECT_EQ(Train(scene, adam_alone, {}, callbacks).lm_left_out, "");
}

TEST(Trainer, OptionsOfLmThatCannotBeFollowedAreNoted) {
  const Scene scene = TrainingScene();
  TrainOptions options = ShortTraining(2, 1);
  EXPECT_THAT(Train(scene, options, {}, {}).notes, testing::IsEmpty());
  options.lm.batches = 1000;
  EXPECT_THAT(Train(scene, options, {}, {}).notes,
              testing::ElementsAre(test::IsNote(notes::kLmInFewerBatches, "10", "1000")));
  options.lm.batches = 1;
  options.lm.l1_weight = options.lm.ssim_weight = 0;
  EXPECT_THAT(Train(scene, options, {}, {}).notes, testing::Contains(test::IsNote(notes::kLmLowersNothing)));
}

// Of 27 and 28 views, four are test views.
TEST(Trainer, ColoursBearWhatTheTrainingViewsDo) {
  TrainOptions options = ShortTraining(2, 0);
  options.sh_degree.reset();
  const auto degree = [&](int views) {
    Scene scene = test::RingOfCameras(views, 24, 16, true);
    test::RenderTruth(test::RandomModel(20, 1, 7), 0.05, &scene);
    return Train(scene, options, {}, {}).model.sh_degree;
  };
  EXPECT_EQ(degree(27), 2);
  EXPECT_EQ(degree(28), 3);
  options.sh_degree = 1;
  EXPECT_EQ(degree(28), 1);
}

TEST(Trainer, NumberOfGaussiansIsLimitedFromTheStart) {
  const Scene scene = TrainingScene();
  for (const bool densifies : {false, true}) {
    TrainOptions options = ShortTraining(60, 1);
    options.density.enabled = densifies;
    options.density.max_gaussians = densifies ? 25 : 100;
    options.adam.sh_degree_interval = 0;
    const TrainResult result = Train(scene, options, {}, {});
    for (const HistoryRow& row : result.history) {
      EXPECT_LE(row.gaussians, densifies ? 25 : 60);
      EXPECT_TRUE(densifies || row.gaussians == 60) << "without densification the number stays";
    }
    EXPECT_EQ(result.model.count, result.history.back().gaussians);
  }
}

TEST(Trainer, TrainsOverABackground) {
  const Scene scene = TrainingScene();
  TrainOptions options = ShortTraining(20, 1);
  options.background = {0.25, 0.5, 1};
  const TrainResult result = Train(scene, options, {}, {});
  EXPECT_EQ(result.model.background, (std::array<float, 3>{0.25f, 0.5f, 1.0f}));
  ExpectLastRowIsOf(result, scene, options.background);
}

TEST(Trainer, RefineWithoutIterationsReturnsTheModel) {
  const Scene scene = TrainingScene();
  const SplatModel model = test::RandomModel(10, 2, 8);
  const TrainResult result = Refine(scene, model, ShortTraining(0, 0), {}, {});
  EXPECT_EQ(result.model.data, model.data);
  EXPECT_EQ(result.model.sh_degree, 2) << "the SH degree of the model, not of the options";
  EXPECT_TRUE(result.lm_report.empty());
  ASSERT_EQ(result.history.size(), 1u);
  EXPECT_EQ(result.history[0].stage, Stage::kLm);
  ExpectLastRowIsOf(result, scene, {0, 0, 0});
}

// Unusable, here with one NaN Gaussian: returned unchanged.
TEST(Trainer, RefineSurvivesAModelThatIsNotANumber) {
  const Scene scene = TrainingScene();
  SplatModel model = test::RandomModel(1, 1, 8);
  model.data[0] = std::nanf("");
  const TrainResult result = Refine(scene, model, ShortTraining(0, 3), {}, {});
  EXPECT_EQ(result.model.count, 1);
  EXPECT_TRUE(std::isnan(result.model.data[0]));
  EXPECT_TRUE(std::isfinite(result.history.back().cost));
}

}  // namespace
}  // namespace vesta::gs
