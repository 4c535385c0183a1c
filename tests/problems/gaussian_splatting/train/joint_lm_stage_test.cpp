// Trainings whose LM stage finds cameras and exposures at once with the splats.
#include "problems/gaussian_splatting/train/joint_lm_stage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

#include "problems/gaussian_splatting/train/lm_state.h"
#include "problems/gaussian_splatting/train/trainer.h"
#include "tests/problems/gaussian_splatting/cameras/bent_photograph.h"
#include "tests/problems/gaussian_splatting/cameras/perturbed_view.h"
#include "tests/problems/gaussian_splatting/train/stopped_training.h"
#include "tests/problems/gaussian_splatting/train/training_scene.h"
#include "tests/support/thread_ranks.h"

namespace vesta::gs {
namespace {

using testing::HasSubstr;

// A splat and photographs of it, whose cameras are off.
class JointLm : public testing::Test {
 protected:
  static TrainOptions Options(CameraChoice choice, int iterations) {
    TrainOptions options = test::ShortTraining(0, iterations);
    options.cameras.refine = choice;
    options.lm.min_gain = 0;
    options.lm.pcg_iterations = 15;
    return options;
  }
  // How far a training view's means are seen from where they should be, the largest, pixels.
  double Off(const std::vector<ViewUnknowns>& found) const {
    const std::vector<View> moved = found.empty() ? given_.views : MovedViews(given_, found);
    double most = 0;
    for (std::size_t v = 0; v < moved.size(); ++v) {
      if (truth_.views[v].is_trained()) {
        most = std::max(most, test::LargestShift(model_, truth_.views[v], moved[v]));
      }
    }
    return most;
  }
  std::string Refusal(const TrainOptions& options) const {
    try {
      Refine(given_, model_, options, 0, {});
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  SplatModel model_ = test::RandomModel(60, 1, 7);
  Scene truth_ = test::RingWithImages(model_, 12, 80, 60), given_ = test::WithCamerasOff(truth_, 0.3, 0.01);
};

// The splat is that of the true cameras, so that there is no frame but theirs.
TEST_F(JointLm, FindsCamerasWithoutAnAdamStage) {
  const double before = Off({});
  ASSERT_GT(before, 0.5);
  const TrainResult result = Refine(given_, model_, Options(CameraChoice::kPose, 20), 0, {});
  ASSERT_EQ(result.cameras.size(), 10U);
  EXPECT_LT(Off(result.cameras), before / 4);
  EXPECT_GT(result.history.back().train.psnr, result.history.front().train.psnr + 8);
  EXPECT_NE(result.model.data, model_.data) << "and the splats with them";
  EXPECT_GT(result.camera_changes.pixels, 0);
  for (const ViewUnknowns& view : result.cameras) EXPECT_TRUE(view.color.is_none());
  // What the history says is so of the model and the cameras that are given back.
  Scene moved = given_;
  moved.views = MovedViews(given_, result.cameras);
  for (std::size_t v = 0; v < moved.views.size(); ++v) moved.views[v].image = given_.views[v].image;
  EXPECT_EQ(Renderer({0, 0, 0}, NearPlane(given_)).Evaluate(result.model, moved).train.psnr,
            result.history.back().train.psnr);
}

// Colours are the same from everywhere, so that they cannot stand in for exposures.
TEST_F(JointLm, FindsExposuresToo) {
  model_ = test::RandomModel(60, 0, 7);
  given_ = test::RingWithImages(model_, 12, 80, 60);
  double log_mean = 0;
  std::vector<double> gains;
  for (std::size_t v = 0; v < given_.views.size(); ++v) {
    if (!given_.views[v].is_trained()) continue;
    gains.push_back(0.89 + 0.02 * static_cast<double>(v));
    log_mean += std::log(gains.back()) / 10;
    for (float& value : given_.views[v].image.rgb) value *= static_cast<float>(gains.back());
  }
  const TrainResult result = Refine(given_, model_, Options(CameraChoice::kPoseAndExposure, 20), 0, {});
  ASSERT_EQ(result.cameras.size(), gains.size());
  double found_mean = 0;
  for (const ViewUnknowns& view : result.cameras) found_mean += std::log(view.color.gain[1]) / 10;
  for (std::size_t i = 0; i < gains.size(); ++i) {
    EXPECT_NEAR(std::log(result.cameras[i].color.gain[1]) - found_mean, std::log(gains[i]) - log_mean, 0.02);
  }
  EXPECT_GT(result.history.back().train.psnr, result.history.front().train.psnr + 3);
}

// All round an object a focal length can be told from the distance.
TEST_F(JointLm, FindsLensesToo) {
  constexpr double kTooLong = 1.02;
  given_ = truth_;
  for (std::size_t v = 0; v < given_.views.size(); ++v) {
    splat::Lens& lens = given_.views[v].camera.lens;
    const double factor = v % 2 == 0 ? kTooLong : 1 / kTooLong;  // two lenses
    lens.fx *= factor, lens.fy *= factor;
  }
  const TrainResult result = Refine(given_, model_, Options(CameraChoice::kAll, 20), 0, {});
  ASSERT_EQ(result.cameras.size(), 10U);
  std::size_t trained = 0;
  for (std::size_t v = 0; v < given_.views.size(); ++v) {
    if (!given_.views[v].is_trained()) continue;
    const LensChange& lens = result.cameras[trained++].lens;
    for (const double log_focal : lens.log_focal)
      EXPECT_NEAR(log_focal, std::log(kTooLong) * (v % 2 == 0 ? -1 : 1), 0.004);
    for (const double shift : lens.shift) EXPECT_NEAR(shift, 0, 0.003);
    EXPECT_EQ(lens.radial[0], 0) << "a pinhole's";
  }
  EXPECT_GT(result.history.back().train.psnr, result.history.front().train.psnr + 6);
}

// Photographs that are bent still, of a model that fills them.
class JointLmOfBent : public JointLm {
 protected:
  JointLmOfBent() {
    test::BentScene scene = test::PhotographsBentBy(kRadial, &model_);
    truth_ = std::move(scene.truth), given_ = std::move(scene.given);
  }
  static constexpr RadialCoefficients kRadial{0.03, -0.01};
};

TEST_F(JointLmOfBent, FindsWhatIsLeft) {
  const TrainResult result = Refine(given_, model_, Options(CameraChoice::kAll, 20), 0, {});
  const Camera& camera = given_.views[0].camera;
  const double before = test::BendLeft(camera, kRadial, {});
  ASSERT_GT(before, 0.4);
  for (const ViewUnknowns& view : result.cameras) {
    EXPECT_LT(test::BendLeft(camera, kRadial, view.lens), before / 4);
    EXPECT_EQ(view.lens, result.cameras[0].lens) << "all have one";
  }
  EXPECT_GT(result.history.back().train.psnr, result.history.front().train.psnr + 3);
}

// Photographs stay as the Adam stage has unbent them while LM looks at them, and are made as LM has found them for all
// others: both after a break too.
TEST_F(JointLmOfBent, ABreakChangesNoBit) {
  TrainOptions options = Options(CameraChoice::kAll, 4);
  options.adam.iterations = 100;
  options.adam.coarse_part = 0;
  options.cameras.joint = true;
  const auto refine = [&](const TrainCallbacks& callbacks) { return Refine(given_, model_, options, 0, callbacks); };
  const TrainResult whole = refine({});
  EXPECT_EQ(whole.history.back().stage, Stage::kLm);
  const Checkpoint checkpoint = test::StoppedAt(2, refine, Stage::kLm);
  EXPECT_NE(checkpoint.run.cameras[0].lens.radial[0], 0);
  const TrainResult result = test::GoneOn(checkpoint, refine);
  EXPECT_EQ(result.model.data, whole.model.data);
  for (std::size_t i = 0; i < whole.cameras.size(); ++i) EXPECT_EQ(result.cameras[i].lens, whole.cameras[i].lens);
}

// What they were unbent by is part of the state.
TEST_F(JointLmOfBent, RefusesASavedStageWhoseBendsAreNone) {
  const TrainOptions options = Options(CameraChoice::kAll, 3);
  const auto refine = [&](const TrainCallbacks& callbacks) { return Refine(given_, model_, options, 0, callbacks); };
  const Checkpoint checkpoint = test::StoppedAt(1, refine);
  const auto with_header = [&](const auto& change) {
    ArchiveReader reader(checkpoint.stage_state);
    LmStageHeader header;
    reader(header);
    EXPECT_EQ(header.unbent_by.size(), 10U);
    EXPECT_TRUE(header.eliminates_views);
    change(header);
    Checkpoint changed = checkpoint;
    changed.stage_state.clear();
    ArchiveWriter writer([&](std::string_view bytes) { changed.stage_state += bytes; });
    writer(header);
    changed.stage_state += reader.rest();
    return changed;
  };
  EXPECT_NO_THROW(test::GoneOn(with_header([](LmStageHeader&) {}), refine));
  EXPECT_THROW(test::GoneOn(with_header([](LmStageHeader& header) { header.unbent_by.pop_back(); }), refine), Error);
  EXPECT_THROW(test::GoneOn(with_header([](LmStageHeader& header) { header.unbent_by[3] = {-10, 0}; }), refine), Error);
  EXPECT_THROW(test::GoneOn(with_header([](LmStageHeader& header) {
                              header.unbent_by[3] = {std::nan(""), 0};
                            }),
                            refine),
               Error);
}

TEST_F(JointLm, GoesOnFromWhatAdamHasFound) {
  TrainOptions options = Options(CameraChoice::kPose, 3);
  options.adam.iterations = 60;
  options.adam.coarse_part = 0;
  const TrainResult apart = Refine(given_, model_, options, 0, {});
  options.cameras.joint = true;
  const TrainResult joint = Refine(given_, model_, options, 0, {});
  ASSERT_EQ(joint.history.size(), apart.history.size());
  const auto same = [&](const HistoryRow& row) { return row.stage == Stage::kAdam || row.iteration == 0; };
  std::size_t k = 0;
  for (; same(joint.history[k]) && k + 1 < joint.history.size(); ++k) {
    // From x in float, which holds the cameras too.
    EXPECT_NEAR(joint.history[k].cost, apart.history[k].cost, 1e-6 * apart.history[k].cost) << k;
  }
  EXPECT_EQ(joint.history[k].stage, Stage::kLm);
  EXPECT_LT(joint.history.back().cost, apart.history.back().cost);
  const double moved = joint.cameras[0].motion.translation[0] - apart.cameras[0].motion.translation[0];
  EXPECT_GT(std::abs(moved), 1e-5) << "more than by x in float";
}

TEST_F(JointLm, ABreakChangesNoBit) {
  for (const CameraChoice choice : {CameraChoice::kPose, CameraChoice::kPoseAndExposure, CameraChoice::kAll}) {
    const TrainOptions options = Options(choice, 5);
    const TrainResult whole = Refine(given_, model_, options, 0, {});
    for (const int stop : {1, 3}) {
      const auto refine = [&](const TrainCallbacks& callbacks) {
        return Refine(given_, model_, options, 0, callbacks);
      };
      const TrainResult result = test::GoneOn(test::StoppedAt(stop, refine), refine);
      EXPECT_EQ(result.model.data, whole.model.data) << stop;
      for (std::size_t i = 0; i < whole.cameras.size(); ++i) {
        EXPECT_EQ(result.cameras[i].motion.translation[0], whole.cameras[i].motion.translation[0]);
        EXPECT_EQ(result.cameras[i].color.gain, whole.cameras[i].color.gain);
        EXPECT_EQ(result.cameras[i].lens, whole.cameras[i].lens);
      }
    }
  }
}

TEST_F(JointLm, RefusesWhatItCannotFind) {
  EXPECT_THAT(Refusal(Options(CameraChoice::kAuto, 1)), HasSubstr("cameras.refine=auto: LM decides nothing"));
  TrainOptions small = Options(CameraChoice::kPose, 1);
  small.memory.budget_gib = 0.003;
  EXPECT_THAT(Refusal(small), HasSubstr("--memory_budget=0.003: "));
}

// The state of the stage has the cameras a second time, as the run has them.
TEST_F(JointLm, RefusesASavedStageWhoseCamerasAreNone) {
  const TrainOptions options = Options(CameraChoice::kPoseAndExposure, 3);
  const auto refine = [&](const TrainCallbacks& callbacks) { return Refine(given_, model_, options, 0, callbacks); };
  Checkpoint checkpoint = test::StoppedAt(1, refine);
  const auto gain = static_cast<float>(checkpoint.run.cameras[2].color.gain[1]);
  const std::size_t at = checkpoint.stage_state.find(std::string(reinterpret_cast<const char*>(&gain), sizeof(gain)));
  ASSERT_NE(at, std::string::npos);
  const float none = -1;
  checkpoint.stage_state.replace(at, sizeof(none), reinterpret_cast<const char*>(&none), sizeof(none));
  EXPECT_THROW(test::GoneOn(checkpoint, refine), Error);
}

// With columns there is no room for, cameras are found all the same.
TEST_F(JointLm, SolvesForCamerasAlongWhereThereIsNoRoomToEliminateThem) {
  TrainOptions options = Options(CameraChoice::kPose, 3);
  const double foreseen = Refine(given_, model_, options, 0, {}).memory.predicted_mib;
  options.memory.budget_gib = (foreseen - 0.5) / 1024;
  const TrainResult result = Refine(given_, model_, options, 0, {});
  EXPECT_THAT(result.notes, testing::Contains(HasSubstr("no room to eliminate")));
  EXPECT_LT(result.memory.predicted_mib, foreseen - 0.5);
  EXPECT_GT(result.history.back().train.psnr, result.history.front().train.psnr + 1);
}

TEST_F(JointLm, TakesAllViewsAsOneBatch) {
  TrainOptions options = Options(CameraChoice::kPose, 2);
  options.lm.batches = 3;
  const TrainResult result = Refine(given_, model_, options, 0, {});
  EXPECT_THAT(result.notes, testing::Contains(HasSubstr("all views as one batch")));
  options.lm.batches = 1;
  EXPECT_EQ(result.model.data, Refine(given_, model_, options, 0, {}).model.data);
}

}  // namespace
}  // namespace vesta::gs
