// SPDX-License-Identifier: Apache-2.0
#include "splatting/density/density.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "kernels/core/archive.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/math/quaternion.h"
#include "tests/splatting/density/density_scene.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

using test::DensityScene;
using test::OpacityOf;

constexpr std::uint64_t kSeed = 5;
constexpr float kStrong = 1e-3f, kWeak = 1e-5f;

std::vector<float> Pulls(Index count, float grad2d) {
  return std::vector<float>(static_cast<std::size_t>(count), grad2d);
}

// Between the weak and the strong gradient.
constexpr double kGradientThreshold = 2e-4;

DensityOptions OptionsThatClone() {
  DensityOptions options;
  options.grow_grad2d = kGradientThreshold;
  options.grow_scale3d = 10;  // all are small
  return options;
}

DensityOptions OptionsThatSplit() {
  DensityOptions options;
  options.grow_grad2d = kGradientThreshold;
  options.grow_scale3d = 1e-3;  // all are large
  return options;
}

// Densifies once, after a view with these gradients.
void DensifyOnce(DensityScene& scene, const DensityOptions& options, const std::vector<float>& grad2d,
                 double extent = 1) {
  DensityControl<Host> control(options, extent, kSeed);
  control.ResetStatistics(scene.model.count);
  scene.Observe(control, grad2d);
  test::ModelAdam adam{LearningRates()};
  test::Densify(control, scene.model, adam, 1);
}

// The mean of Gaussian i.
std::array<float, 3> MeanOf(const SplatModel& model, Index i) {
  return {model.attribute(0)[i], model.attribute(1)[i], model.attribute(2)[i]};
}

TEST(Density, LeavesWhatIsPulledLittle) {
  DensityScene scene(8);
  const SplatModel before = scene.model;
  DensifyOnce(scene, OptionsThatClone(), Pulls(8, kWeak));
  EXPECT_EQ(scene.model.data, before.data);
}

TEST(Density, ThresholdIsOnTheMeanOverObservations) {
  DensityScene scene(4);
  DensityControl<Host> control(OptionsThatClone(), 1, kSeed);
  control.ResetStatistics(4);
  test::ModelAdam adam{LearningRates()};
  DensityControl<Host> more(OptionsThatClone(), 1, kSeed);
  more.ResetStatistics(4);
  // The mean is 1.75e-4; another observation raises it to 2.5e-4, above the threshold of 2e-4.
  for (DensityControl<Host>* each : {&control, &more}) {
    scene.Observe(*each, Pulls(4, 1.5e-4f));
    scene.Observe(*each, Pulls(4, 2.0e-4f));
  }
  test::Densify(control, scene.model, adam, 1);
  EXPECT_EQ(scene.model.count, 4);
  scene.Observe(more, Pulls(4, 4.0e-4f));
  test::Densify(more, scene.model, adam, 1);
  EXPECT_EQ(scene.model.count, 8);
  // Densification resets the observations.
  test::Densify(more, scene.model, adam, 2);
  EXPECT_EQ(scene.model.count, 8);
}

// On the optical axis of an unrotated camera, with colours independent of direction, x and y of the mean act only
// through the screen position: f / z pixels per unit.
TEST(Density, Grad2dIsTheGradientByTheScreenMean) {
  DensityScene scene(1);
  View& camera = scene.scene.views[0];
  camera.camera = {64, 48, {70, 80, 32, 24}};
  camera.rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  camera.translation = {0, 0, 4};
  SplatModel model = test::RandomModel(1, 0, 2);
  for (int k = 0; k < 3; ++k) model.attribute(splat::kMean + k)[0] = 0, model.attribute(splat::kLogScale + k)[0] = -2;
  scene.view.Build(ToKernelModel(model), ToPosedCamera(camera, 0.01), std::array<double, 3>{}.data(), scene.workspace);
  Image image(64, 48);
  scene.view.Render(image.rgb.data());
  vesta::test::Random random(3);
  const std::vector<float> u = random.NormalVector<float>(image.rgb.size());
  std::vector<float> gradient(model.data.size());
  scene.view.AddJT(ToKernelModel(model), image.rgb.data(), u.data(), gradient.data(), scene.workspace);
  const double grad2d = std::hypot(gradient[0] * 4 / 70 * 32, gradient[1] * 4 / 80 * 24) / 5;
  for (const double factor : {0.999, 1.001}) {
    DensityOptions options = OptionsThatClone();
    options.grow_grad2d = factor * grad2d;
    DensityControl<Host> control(options, 1, kSeed);
    control.ResetStatistics(1);
    control.Observe(density::Grad2dOf(scene.view, scene.workspace.splat_sums.data(), 5));
    SplatModel changed = model;
    test::ModelAdam adam{LearningRates()};
    test::Densify(control, changed, adam, 1);
    EXPECT_EQ(changed.count, factor < 1 ? 2 : 1);
  }
}

TEST(Density, ClonesKeepTheJointOpacityAndAllElse) {
  constexpr Index kCount = 6;
  DensityScene scene(kCount);
  const float logits[kCount] = {-5, -1, 0, 3, 9, 20};
  std::copy(std::begin(logits), std::end(logits), scene.model.attribute(splat::kOpacity));
  const SplatModel before = scene.model;
  DensifyOnce(scene, OptionsThatClone(), Pulls(kCount, kStrong));
  ASSERT_EQ(scene.model.count, 2 * kCount);
  for (Index i = 0; i < kCount; ++i) {
    for (int a = 0; a < before.num_attributes(); ++a) {
      EXPECT_EQ(scene.model.attribute(a)[2 * i], scene.model.attribute(a)[2 * i + 1]) << "clones are adjacent";
      EXPECT_TRUE(a == splat::kOpacity || scene.model.attribute(a)[2 * i] == before.attribute(a)[i]);
    }
    const double each = OpacityOf(scene.model, 2 * i), joint = 1 - (1 - each) * (1 - each);
    EXPECT_NEAR(joint, OpacityOf(before, i), 1e-6 + 1e-5 * OpacityOf(before, i)) << logits[i];
  }
}

// exp of an extreme logit overflows in float.
TEST(Density, ClonesOfOpaqueGaussiansStayFinite) {
  DensityScene scene(1);
  for (const float logit : {40.0f, 100.0f, 300.0f}) {
    scene.model = test::RandomModel(1, 1, 1);
    *scene.model.attribute(splat::kOpacity) = logit;
    DensifyOnce(scene, OptionsThatClone(), Pulls(1, kStrong));
    ASSERT_EQ(scene.model.count, 2);
    EXPECT_NEAR(*scene.model.attribute(splat::kOpacity), logit / 2, 1e-3);
  }
}

TEST(Density, SplitsShrinkAndScatter) {
  constexpr Index kCount = 40;
  DensityScene scene(kCount);
  const SplatModel before = scene.model;
  DensifyOnce(scene, OptionsThatSplit(), Pulls(kCount, kStrong));
  ASSERT_EQ(scene.model.count, 2 * kCount);
  double squares = 0;
  for (Index child = 0; child < 2 * kCount; ++child) {
    const Index parent = child / 2;
    float q[4], R[9];
    for (int k = 0; k < 4; ++k) q[k] = before.attribute(splat::kQuaternion + k)[parent];
    RotationFromQuaternion(q, R);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(scene.model.attribute(splat::kLogScale + k)[child],
                  before.attribute(splat::kLogScale + k)[parent] - std::log(1.6), 1e-6);
      // Offset along principal axis k, in standard deviations.
      double along = 0;
      for (int r = 0; r < 3; ++r) {
        along += R[3 * r + k] * (scene.model.attribute(r)[child] - before.attribute(r)[parent]);
      }
      along /= std::exp(before.attribute(splat::kLogScale + k)[parent]);
      EXPECT_LT(std::abs(along), 4.5);
      squares += along * along;
    }
    for (int a = splat::kQuaternion; a < before.num_attributes(); ++a) {
      EXPECT_EQ(scene.model.attribute(a)[child], before.attribute(a)[parent]);
    }
    EXPECT_NE(MeanOf(scene.model, child), MeanOf(scene.model, child ^ 1));
  }
  // 240 standard normal samples: the mean square is 1 within 4 standard deviations of 0.09.
  EXPECT_NEAR(squares / (6 * kCount), 1, 0.36);
}

TEST(Density, SplitsWhatIsLargeAndClonesWhatIsSmall) {
  DensityScene scene(2);
  for (int k = 0; k < 3; ++k) {
    scene.model.attribute(splat::kLogScale + k)[0] = std::log(0.019f);
    scene.model.attribute(splat::kLogScale + k)[1] = std::log(k == 1 ? 0.021f : 0.001f);
  }
  const SplatModel before = scene.model;
  DensifyOnce(scene, {}, Pulls(2, kStrong), 2);  // the limit is 1 % of an extent of 2
  ASSERT_EQ(scene.model.count, 4);
  EXPECT_EQ(MeanOf(scene.model, 0), MeanOf(before, 0));
  EXPECT_EQ(MeanOf(scene.model, 1), MeanOf(before, 0));
  EXPECT_NE(MeanOf(scene.model, 2), MeanOf(before, 1));
  EXPECT_NE(MeanOf(scene.model, 3), MeanOf(before, 1));
}

TEST(Density, CapIsHardAndGoesToTheStrongest) {
  constexpr Index kCount = 10, kRoom = 3;
  DensityScene scene(kCount);
  DensityOptions options = OptionsThatClone();
  options.max_gaussians = kCount + kRoom;
  DensityControl<Host> control(options, 1, kSeed);
  control.ResetStatistics(kCount);
  std::vector<float> grad2d;
  for (Index i = 0; i < kCount; ++i) grad2d.push_back(kStrong * static_cast<float>(1 + (7 * i) % kCount));
  const SplatModel before = scene.model;
  scene.Observe(control, grad2d);
  test::ModelAdam adam{LearningRates()};
  test::Densify(control, scene.model, adam, 1);
  ASSERT_EQ(scene.model.count, kCount + kRoom);
  std::vector<Index> cloned;
  for (Index i = 0, at = 0; i < kCount; ++i) {
    const bool is_cloned = OpacityOf(scene.model, at) != OpacityOf(before, i);
    if (is_cloned) cloned.push_back(i);
    at += is_cloned ? 2 : 1;
  }
  EXPECT_EQ(cloned, (std::vector<Index>{1, 4, 7})) << "the largest gradients, 8, 9 and 10";
  for (int round = 2; round < 5; ++round) {
    scene.Observe(control, Pulls(scene.model.count, kStrong));
    test::Densify(control, scene.model, adam, round);
    EXPECT_EQ(scene.model.count, kCount + kRoom);
  }
}

TEST(Density, RoomThatWasNotThereIsNotForgotten) {
  constexpr Index kCount = 10;
  DensityOptions options = OptionsThatClone();
  options.max_gaussians = 100;
  DensityControl<Host> before(options, 1, kSeed);
  before.ResetStatistics(kCount);
  before.LimitGaussians(kCount + 4);
  std::string saved;
  ArchiveWriter writer([&](std::string_view bytes) { saved += bytes; });
  before.Visit(writer);
  for (const Index most : {kCount + 2, kCount + 8}) {  // limits of the resumed run
    DensityScene scene(kCount);
    options.max_gaussians = most;
    DensityControl<Host> control(options, 1, kSeed);
    ArchiveReader reader(saved);
    control.Visit(reader);
    scene.Observe(control, Pulls(kCount, kStrong));
    test::ModelAdam adam{LearningRates()};
    test::Densify(control, scene.model, adam, 1);
    EXPECT_EQ(scene.model.count, std::min(most, kCount + 4));
  }
}

// Pruned Gaussians free places.
TEST(Density, PrunesTheTransparentAndTheHuge) {
  DensityScene scene(5);
  scene.model.attribute(splat::kOpacity)[1] = -5.4f;                // opacity 0.0045
  scene.model.attribute(splat::kOpacity)[4] = -5.2f;                // 0.0055
  scene.model.attribute(splat::kLogScale + 2)[3] = std::log(0.9f);  // exceeds the limit for an extent of 2
  DensityOptions options = OptionsThatClone();
  options.prune_scale3d = 0.4;
  options.max_gaussians = 5;
  const SplatModel before = scene.model;
  DensityControl<Host> control(options, 2, kSeed);
  control.ResetStatistics(5);
  test::ModelAdam adam{LearningRates()};
  test::Densify(control, scene.model, adam, 1);
  ASSERT_EQ(scene.model.count, 3);
  EXPECT_EQ(MeanOf(scene.model, 0), MeanOf(before, 0));
  EXPECT_EQ(MeanOf(scene.model, 1), MeanOf(before, 2));
  EXPECT_EQ(MeanOf(scene.model, 2), MeanOf(before, 4));
  scene.Observe(control, Pulls(3, kStrong));
  test::Densify(control, scene.model, adam, 2);
  EXPECT_EQ(scene.model.count, 5);
}

TEST(Density, NeverEmptiesAModel) {
  DensityScene scene(3);
  std::fill_n(scene.model.attribute(splat::kOpacity), 3, -9.0f);
  const SplatModel before = scene.model;
  DensityControl<Host> control({}, 1, kSeed);
  control.ResetStatistics(3);
  test::ModelAdam adam{LearningRates()};
  test::Densify(control, scene.model, adam, 1);
  EXPECT_EQ(scene.model.data, before.data);
}

TEST(Density, ResetLowersOpacities) {
  SplatModel model = test::RandomModel(3, 0, 4);
  model.attribute(splat::kOpacity)[1] = -7;
  test::ModelAdam adam{LearningRates()};
  DensityControl<Host>::LowerOpacities(model.data.data(), model.count);
  EXPECT_NEAR(OpacityOf(model, 0), 0.01, 1e-8);
  EXPECT_EQ(model.attribute(splat::kOpacity)[1], -7);
  EXPECT_NEAR(OpacityOf(model, 2), 0.01, 1e-8);
}

// Old Gaussians keep moving by momentum, new ones follow the new gradient.
TEST(Density, MomentsFollowTheModel) {
  DensityScene scene(4);
  test::ModelAdam adam{LearningRates()};
  std::vector<float> gradient(scene.model.data.size(), 1.0f);
  adam.Step(scene.model, gradient.data(), scene.model.num_attributes(), 1);
  DensityControl<Host> control(OptionsThatClone(), 1, kSeed);
  control.ResetStatistics(4);
  scene.Observe(control, {kStrong, 0, 0, kStrong});
  test::Densify(control, scene.model, adam, 1);
  ASSERT_EQ(scene.model.count, 6);
  const SplatModel before = scene.model;
  gradient.assign(scene.model.data.size(), -1e-3f);
  adam.Step(scene.model, gradient.data(), scene.model.num_attributes(), 1);
  for (Index i = 0; i < 6; ++i) {
    const bool is_new = i == 1 || i == 5;
    EXPECT_EQ(MeanOf(scene.model, i)[0] > MeanOf(before, i)[0], is_new) << "new Gaussians start without moments";
  }
}

}  // namespace
}  // namespace vesta::gs
