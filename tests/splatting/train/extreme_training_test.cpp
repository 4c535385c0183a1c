// SPDX-License-Identifier: Apache-2.0
// Short trainings of extreme scenes, and of one scene in other frames, units and orders.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "kernels/core/check.h"
#include "kernels/math/quaternion.h"
#include "problems/gaussian_splatting/model/scene_frame.h"
#include "tests/problems/gaussian_splatting/lm/extreme_problem.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/throws_error.h"

namespace vesta::gs::test {
namespace {

class ExtremeTraining : public testing::TestWithParam<ExtremeProblem> {};
INSTANTIATE_TEST_SUITE_P(Of, ExtremeTraining, testing::ValuesIn(kExtremeProblems),
                         [](const auto& param) { return std::string(param.param.name); });

// Both stages end with a finite model, no worse than an image of one colour, and throw nothing.
TEST_P(ExtremeTraining, EndsWithAUsableModel) {
  const ExtremeProblem& c = GetParam();
  Scene scene = RingOfCameras(c.views, c.width, c.height, false);
  RenderTruth(RandomModel(kExtremeCount, 1, 230), 0.05, &scene);
  c.change(scene);
  scene.extent = SceneExtent(scene.views, scene.points);
  const TrainResult result = Train(scene, ShortTraining(60, 2), {}, {});
  EXPECT_GT(result.model.count, 0);
  EXPECT_TRUE(IsFinite(result.model.data));
  ASSERT_GE(result.history.size(), 2u);
  for (const HistoryRow& row : result.history) {
    EXPECT_TRUE(std::isfinite(row.cost) && row.cost >= 0);
    EXPECT_FALSE(std::isnan(row.train.psnr) || std::isnan(row.train.ssim));
  }
  EXPECT_LE(result.history.back().cost, result.history.front().cost);
}

TEST(ExtremeTrainings, ImagesOfPixelsThatAreNotFiniteAreRefused) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    for (const bool in_test_view : {false, true}) {
      Scene scene = TrainingScene();
      View& view = scene.views[in_test_view ? 8 : 5];
      ASSERT_EQ(view.is_test(), in_test_view);
      view.image.rgb[77] = bad;
      EXPECT_THAT([&] { Train(scene, ShortTraining(10, 1), {}, {}); }, ThrowsError(kBadArgument, view.name));
    }
  }
}

// The scene in another frame, x' = scale Q x + move, as if read from files.
Scene InFrame(const double (&quaternion)[4], double scale, const std::array<double, 3>& move) {
  Scene scene = TrainingScene();
  double Q[9];
  RotationFromQuaternion(quaternion, Q);
  WorldPoints points;
  points.colors = scene.points.colors;
  for (const auto& position : scene.points.positions) {
    auto& to = points.positions.emplace_back(move);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) to[i] += scale * Q[3 * i + k] * static_cast<double>(position[k]);
    }
  }
  for (View& view : scene.views) {
    const auto R = view.rotation;
    for (std::size_t i = 0; i < 3; ++i) {
      view.translation[i] *= scale;
      for (std::size_t j = 0; j < 3; ++j) {
        view.rotation[3 * i + j] = 0;
        for (std::size_t k = 0; k < 3; ++k) view.rotation[3 * i + j] += R[3 * i + k] * Q[3 * j + k];
        view.translation[i] -= view.rotation[3 * i + j] * move[j];
      }
    }
  }
  scene.points = {};
  PlaceInScene(points, &scene);
  return scene;
}

constexpr double kIdentity[4] = {1, 0, 0, 0}, kTurn[4] = {0.3, -0.7, 0.2, 0.6};

struct Frame {
  const char* name;
  Scene (*make)();
  double tolerance;  // dB
};
void PrintTo(const Frame& frame, std::ostream* os) { *os << frame.name; }

constexpr Frame kFrames[] = {
    {"ScaledBy1em8", [] { return InFrame(kIdentity, 1e-8, {}); }, 0.2},
    {"ScaledBy1em4", [] { return InFrame(kIdentity, 1e-4, {}); }, 0.2},
    {"ScaledBy1e8", [] { return InFrame(kIdentity, 1e8, {}); }, 0.2},
    {"MovedBy1e4Sizes",
     [] {
       return InFrame(kIdentity, 1, {3e4, -1e4, 2e4});
     },
     0.2},
    {"Turned", [] { return InFrame(kTurn, 1, {}); }, 1},
    {"TurnedScaledAndMoved",
     [] {
       return InFrame(kTurn, 1e4, {-2e8, 1e8, 1e8});
     },
     1},
};

class TrainingInFrame : public testing::TestWithParam<Frame> {};
INSTANTIATE_TEST_SUITE_P(Of, TrainingInFrame, testing::ValuesIn(kFrames),
                         [](const auto& param) { return std::string(param.param.name); });

HistoryRow LastRowOf(const Scene& scene) { return Train(scene, ShortTraining(150, 2), {}, {}).history.back(); }

// Rounding errors grow differently, but the quality stays. Adam's steps depend on the axes of the world, so a rotation
// may change the result more.
TEST_P(TrainingInFrame, ReachesTheSameQuality) {
  const HistoryRow own = LastRowOf(InFrame(kIdentity, 1, {})), other = LastRowOf(GetParam().make());
  ASSERT_GT(own.train.psnr, 22);
  EXPECT_NEAR(other.train.psnr, own.train.psnr, GetParam().tolerance);
  EXPECT_NEAR(other.test.psnr, own.test.psnr, GetParam().tolerance);
  EXPECT_NEAR(static_cast<double>(other.gaussians), static_cast<double>(own.gaussians), 5);
}

// The order of views changes only the rounding of sums.
TEST(ExtremeTrainings, OrderOfViewsDoesNotMatterToLm) {
  const auto refine = [](const Scene& scene) {
    return Refine(scene, Perturbed(RandomModel(60, 1, 7), 0.05, 8), ShortTraining(0, 3), {}, {}).history.back();
  };
  Scene scene = TrainingScene();
  const HistoryRow own = refine(scene);
  std::ranges::reverse(scene.views);
  const HistoryRow other = refine(scene);
  EXPECT_NEAR(other.cost, own.cost, 1e-3 * own.cost);
  EXPECT_NEAR(other.test.psnr, own.test.psnr, 0.02);
}

// Points are sorted first: their order in the file changes no bit.
TEST(ExtremeTrainings, OrderOfPointsDoesNotMatter) {
  Scene scene = TrainingScene();
  const SplatModel own = Train(scene, ShortTraining(40, 1), {}, {}).model;
  std::ranges::reverse(scene.points.positions);
  std::ranges::reverse(scene.points.colors);
  const SplatModel other = Train(scene, ShortTraining(40, 1), {}, {}).model;
  EXPECT_TRUE(own.data == other.data);
}

}  // namespace
}  // namespace vesta::gs::test
