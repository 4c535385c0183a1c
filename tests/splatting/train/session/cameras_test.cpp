// SPDX-License-Identifier: Apache-2.0
// Trainings that refine cameras and exposures.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "splatting/cameras/unknowns/gauge.h"
#include "splatting/train/session/checkpoint.h"
#include "splatting/train/session/training_cameras.h"
#include "tests/splatting/cameras/perturbed_view.h"
#include "tests/splatting/train/is_note.h"
#include "tests/splatting/train/stopped_training.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/throws_error.h"

namespace vesta::gs {
namespace {

using testing::Contains;

// Camera errors are up to 0.5 degrees and 0.5 % of the distance.
class CamerasFoundAlong : public testing::Test {
 protected:
  static TrainOptions Options(CameraChoice choice, int iterations) {
    TrainOptions options = test::ShortTraining(iterations, 0);
    options.cameras.refine = choice;
    options.adam.half_resolution_until = 0;
    return options;
  }
  static std::vector<const View*> TrainedOn(const Scene& scene) {
    std::vector<const View*> views;
    for (const View& view : scene.views) {
      if (view.is_trained()) views.push_back(&view);
    }
    return views;
  }
  // Largest error of a projected mean in the training views, pixels, up to the similarity that fits all views best.
  double Off(const std::vector<ViewUnknowns>& found) const {
    const std::vector<View> moved = MovedViews(given_, found);
    const std::vector<const View*> truth = TrainedOn(truth_);
    std::vector<ViewUnknowns> apart;
    for (std::size_t v = 0; v < moved.size(); ++v) {
      const View &from = truth_.views[v], &to = moved[v];
      if (!from.is_trained()) continue;
      apart.emplace_back().motion = MotionBetween(from, to);
    }
    for (int round = 0; round < 8; ++round) FixCameraGauge(truth, 3, &apart);
    double most = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      most = std::max(most, test::LargestShift(model_, MovedView(*truth[i], apart[i].motion), *truth[i]));
    }
    return most;
  }

  SplatModel model_ = test::RandomModel(60, 1, 7);
  Scene truth_ = test::RingWithImages(model_, 12, 80, 60), given_ = test::WithCamerasOff(truth_, 0.5, 0.015);
};

TEST_F(CamerasFoundAlong, PerturbedPosesComeBack) {
  const double before = Off({});
  ASSERT_GT(before, 0.5);
  const TrainResult result = Refine(given_, model_, Options(CameraChoice::kPose, 300), {}, {});
  ASSERT_EQ(result.cameras.size(), 10U);
  EXPECT_LT(Off(result.cameras), before / 10);
  EXPECT_GT(result.history.back().train.psnr, result.history.front().train.psnr + 5);
  EXPECT_TRUE(std::ranges::all_of(result.cameras, [](const ViewUnknowns& view) { return view.color.is_none(); }));
}

TEST_F(CamerasFoundAlong, ExposuresComeBackToTheirMean) {
  double mean = 0;
  std::vector<double> gains;
  given_ = truth_;
  for (std::size_t v = 0; v < given_.views.size(); ++v) {
    View& view = given_.views[v];
    if (!view.is_trained()) continue;
    gains.push_back(0.8 + 0.04 * static_cast<double>(v));
    mean += gains.back() / 10;
    for (float& value : view.image.rgb) value *= static_cast<float>(gains.back());
  }
  TrainOptions options = Options(CameraChoice::kPoseAndExposure, 1000);
  options.adam.lr_scale = 1;  // the splat models the mean exposure
  const TrainResult result = Refine(given_, model_, options, {}, {});
  ASSERT_EQ(result.cameras.size(), gains.size());
  for (std::size_t i = 0; i < gains.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(result.cameras[i].color.gain[c], gains[i] / mean, 0.01);
  }
}

// The gauge is fixed whenever all views were processed once, even within an iteration over several views.
TEST_F(CamerasFoundAlong, TheGaugeIsHeldOnceAnEpoch) {
  given_ = truth_;
  for (std::size_t v = 0; v < given_.views.size(); ++v) {
    for (float& value : given_.views[v].image.rgb) value *= static_cast<float>(0.8 + 0.04 * static_cast<double>(v));
  }
  TrainOptions options = Options(CameraChoice::kPoseAndExposure, 400);
  options.adam.batch_size = 4;
  const auto train = [&](const TrainCallbacks& callbacks) { return Refine(given_, model_, options, {}, callbacks); };
  const auto mean_gain = [&](int iterations) {
    double mean = 0;
    for (const ViewUnknowns& view : test::StoppedAt(iterations, train).run.cameras) mean += view.color.gain[0] / 10;
    return mean;
  };
  // last + 1 iterations are done. With ten views and four per iteration, an epoch ends in iteration 3 (12 views), 5
  // (20) and 8 (32).
  for (const int last : {2, 4, 7}) EXPECT_NEAR(mean_gain(last), 1, 1e-12) << last;
  for (const int last : {3, 5, 6}) EXPECT_GT(std::abs(mean_gain(last) - 1), 1e-4) << last;
}

// At 60 % of the stage, right after an epoch, the mean rotation is still fixed unless eps2d is small.
TEST_F(CamerasFoundAlong, TheMeanTurnIsFreeSoonerWithANarrowFilter) {
  for (const double eps2d : {0.3, 0.02}) {
    SCOPED_TRACE(eps2d);
    TrainOptions options = Options(CameraChoice::kPose, 100);
    options.eps2d = eps2d;
    for (View& view : given_.views) view.camera.eps2d = eps2d;
    const auto train = [&](const TrainCallbacks& callbacks) { return Refine(given_, model_, options, {}, callbacks); };
    const std::vector<ViewUnknowns> found = test::StoppedAt(59, train).run.cameras;
    std::vector<ViewUnknowns> apart = found;
    SubtractMeanRotation(&apart);
    double most = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      most = std::max(most, std::abs(found[i].motion.Angle() - apart[i].motion.Angle()));
    }
    if (eps2d < 0.1) {
      EXPECT_GT(most, 1e-5);
    } else {
      EXPECT_LT(most, 1e-7);  // rotations do not commute exactly
    }
  }
}

TEST_F(CamerasFoundAlong, BandsOfHarmonicsWaitForExposures) {
  for (const auto& [choice, first] :
       {std::pair{CameraChoice::kPose, 9}, std::pair{CameraChoice::kPoseAndExposure, 17}}) {
    TrainOptions options = Options(choice, 100);
    options.adam.sh_degree_interval = 0.08;
    TrainCallbacks callbacks;
    callbacks.snapshot_every = {.iterations = 1};
    int begins = 0;
    callbacks.snapshot = [&](Stage, int iteration, const splat::Model<float>& model) {
      if (begins == 0 && model.active_sh_degree == 1) begins = iteration;
    };
    Train(given_, options, {}, callbacks);
    EXPECT_EQ(begins, first);
  }
}

// All around an object, the focal length is determined.
TEST_F(CamerasFoundAlong, LensesComeBack) {
  constexpr double kTooLong = 1.02;
  for (View& view : given_.views) {
    splat::Lens& lens = view.camera.lens;
    lens.fx *= kTooLong, lens.fy *= kTooLong;
  }
  const TrainResult result = Refine(given_, model_, Options(CameraChoice::kAll, 400), {}, {});
  ASSERT_EQ(result.cameras.size(), 10U);
  for (const ViewUnknowns& view : result.cameras) {
    for (const double log_focal : view.lens.log_focal) EXPECT_NEAR(log_focal, -std::log(kTooLong), 0.005);
    for (const double shift : view.lens.shift) EXPECT_NEAR(shift, 0, 0.005);
  }
  EXPECT_NEAR(result.camera_changes.most_focal, 1 - 1 / kTooLong, 0.005);
  const std::vector<View> found = MovedViews(given_, result.cameras);
  for (std::size_t v = 0; v < found.size(); ++v)
    EXPECT_EQ(found[v].camera, found[1].camera) << "test views share the lens";
}

// A common rotation is found mostly as poses, not as a shift of the principal point.
TEST_F(CamerasFoundAlong, LensesTakeNoTurn) {
  constexpr double kTurn = 0.03;
  for (std::size_t v = 0; v < given_.views.size(); ++v) {
    given_.views[v] = test::PerturbedView(truth_.views[v], splat::Compose({{kTurn, 0, 0}}, {}));
  }
  TrainOptions options = Options(CameraChoice::kAll, 400);
  options.adam.lr_scale = 0.03;  // the splat is already right
  const TrainResult result = Refine(given_, model_, options, {}, {});
  for (const ViewUnknowns& view : result.cameras) {
    for (const double shift : view.lens.shift) EXPECT_NEAR(shift, 0, kTurn / 2);
    EXPECT_NEAR(view.motion.Angle(), kTurn, kTurn / 2);
  }
}

TEST_F(CamerasFoundAlong, RefusesLensesThatDistort) {
  given_.views[3].bent = LensCamera{given_.views[3].camera, {.radial = {-0.1}}};
  EXPECT_THAT([&] { Refine(given_, model_, Options(CameraChoice::kAll, 1), {}, {}); },
              ThrowsError(kUnsupported, "--refine_cameras=all", given_.views[3].name));
  EXPECT_NO_THROW(Refine(given_, model_, Options(CameraChoice::kPoseAndExposure, 1), {}, {}));
}

TEST_F(CamerasFoundAlong, AutomaticallyWhereTheyAreOff) {
  const TrainResult off = Refine(given_, model_, Options(CameraChoice::kAuto, 100), {}, {});
  EXPECT_THAT(off.notes, Contains(test::IsNote(notes::kCamerasChosen, "pose")));
  EXPECT_GT(off.history.back().train.psnr, off.history.front().train.psnr + 3);
  const TrainResult right = Refine(truth_, model_, Options(CameraChoice::kAuto, 100), {}, {});
  EXPECT_THAT(right.notes, Contains(test::IsNote(notes::kCamerasChosen, "none")));
  for (const ViewUnknowns& view : right.cameras) EXPECT_EQ(view.motion.Angle(), 0);
}

TEST_F(CamerasFoundAlong, ABreakChangesNoBit) {
  for (const CameraChoice choice : {CameraChoice::kPoseAndExposure, CameraChoice::kAll, CameraChoice::kAuto}) {
    TrainOptions options = Options(choice, 60);
    options.adam.half_resolution_until = 0.5;
    options.adam.lr_scale = 1;
    options.density.every = 0.2;
    const TrainResult whole = Train(given_, options, {}, {});
    for (const int stop : {2, 7, 25, 45}) {
      const auto train = [&](const TrainCallbacks& callbacks) { return Train(given_, options, {}, callbacks); };
      const TrainResult result = test::ResumeFrom(test::StoppedAt(stop, train), train);
      EXPECT_EQ(result.model.data, whole.model.data) << stop;
      ASSERT_EQ(result.cameras.size(), whole.cameras.size());
      for (std::size_t i = 0; i < whole.cameras.size(); ++i) {
        EXPECT_EQ(result.cameras[i].motion.translation[0], whole.cameras[i].motion.translation[0]);
        EXPECT_EQ(result.cameras[i].color.gain, whole.cameras[i].color.gain);
        EXPECT_EQ(result.cameras[i].lens, whole.cameras[i].lens);
      }
    }
  }
}

// One view; identical views; a camera that looks away; a black photograph.
TEST_F(CamerasFoundAlong, OddScenesStayFinite) {
  Scene one = given_;
  one.views.resize(2);
  Scene alike = given_;
  for (std::size_t v = 1; v < alike.views.size(); ++v) {
    const ViewRole role = alike.views[v].role;
    alike.views[v] = alike.views[0], alike.views[v].role = role;
  }
  Scene blind = given_;
  for (double& r : blind.views[2].rotation) r = -r;
  for (std::size_t k = 3; k < 6; ++k) blind.views[2].rotation[k] = -blind.views[2].rotation[k];
  for (std::size_t k = 0; k < 3; ++k) blind.views[2].translation[k] *= k == 1 ? 1 : -1;
  Scene black = given_;
  std::ranges::fill(black.views[3].image.rgb, 0.0f);
  for (const Scene* scene : {&one, &alike, &blind, &black}) {
    for (const CameraChoice choice : {CameraChoice::kPoseAndExposure, CameraChoice::kAll, CameraChoice::kAuto}) {
      const TrainResult result = Refine(*scene, model_, Options(choice, 40), {}, {});
      EXPECT_TRUE(std::isfinite(result.history.back().cost));
      for (const ViewUnknowns& view : result.cameras) {
        EXPECT_TRUE(std::isfinite(view.motion.Angle()));
        EXPECT_LT(view.motion.Angle(), 1);
        for (const double gain : view.color.gain) EXPECT_TRUE(std::isfinite(gain) && gain > 0);
        for (const double log_focal : view.lens.log_focal) EXPECT_LT(std::abs(log_focal), 0.5);
      }
    }
  }
}

TEST(TrainingCameras, ShowWhatWasFoundAndTakeNothingElse) {
  const Scene given = test::TrainingScene();
  CameraOptions options;
  TrainingCameras as_given(given, options);
  EXPECT_EQ(&as_given.scene(), &given);
  EXPECT_TRUE(as_given.found().empty());
  options.refine = CameraChoice::kAll;
  TrainingCameras cameras(given, options);
  ASSERT_EQ(cameras.views().size(), 10U);
  std::vector<ViewUnknowns> found = cameras.found();
  found[4].motion = test::RandomMotion(1, 0.1, 2);
  found[4].color = {{2, 1, 0.5}, {0.1, 0, 0}};
  for (ViewUnknowns& view : found) view.lens.log_focal[1] = 0.1;
  ASSERT_TRUE(cameras.Restore(found));
  const View &now = *cameras.views()[4], &before = *cameras.given()[4];
  EXPECT_EQ(now.rotation, MovedView(before, found[4].motion).rotation);
  EXPECT_EQ(now.camera, AsFound(before, found[4]).camera);
  EXPECT_EQ(now.image.rgb, before.image.rgb) << "exposure not applied yet";
  const float* const values = now.image.rgb.data();
  EXPECT_TRUE(cameras.Develop(4));
  EXPECT_FALSE(cameras.Develop(4));
  EXPECT_EQ(now.image.rgb.data(), values);
  EXPECT_NEAR(now.image.rgb[0], (before.image.rgb[0] - 0.1f) / 2, 1e-6);
  EXPECT_EQ(cameras.views()[3]->image.rgb, cameras.given()[3]->image.rgb);
  // Undoing it restores the same bits.
  ASSERT_TRUE(cameras.Restore(std::vector<ViewUnknowns>(10)));
  cameras.DevelopAll();
  EXPECT_EQ(now.image.rgb, before.image.rgb);
  EXPECT_EQ(now.rotation, before.rotation);
  found[2].color.gain[1] = 0;
  EXPECT_FALSE(cameras.Restore(found));
  found[2].color.gain[1] = NAN;
  EXPECT_FALSE(cameras.Restore(found));
  found[2].color.gain[1] = 1;
  for (ViewUnknowns& view : found) view.lens.log_focal[0] = 50;
  EXPECT_FALSE(cameras.Restore(found));
  for (ViewUnknowns& view : found) view.lens = {};
  EXPECT_TRUE(cameras.Restore(found));
  // All views share one lens: invalid.
  found[2].lens.log_focal[0] = 0.01;
  EXPECT_FALSE(cameras.Restore(found));
  found[2].lens = {};
  for (double& q : found[2].motion.quaternion) q = 0;
  EXPECT_FALSE(cameras.Restore(found));
  EXPECT_FALSE(cameras.Restore({}));
  // Changes of fixed parameters are invalid.
  options.refine = CameraChoice::kPose;
  TrainingCameras poses(given, options);
  std::vector<ViewUnknowns> moved(10);
  moved[1].motion = test::RandomMotion(1, 0.1, 2);
  EXPECT_TRUE(poses.Restore(moved));
  moved[1].color.gain[0] = 2;
  EXPECT_FALSE(poses.Restore(moved));
  moved[1].color = {};
  for (ViewUnknowns& view : moved) view.lens.log_focal[0] = 0.01;
  EXPECT_FALSE(poses.Restore(moved));
}

}  // namespace
}  // namespace vesta::gs
