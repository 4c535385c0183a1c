#include "problems/gaussian_splatting/cameras/lens_steps.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "kernels/core/error.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

constexpr FreeUnknowns kAll{true, true, true}, kBentToo{true, true, true, true};
constexpr LensLimit kNoLimit{10, 1};

// The system of a view whose cost is least at the step that is wanted.
struct ViewSystem {
  std::vector<double> curvature, gradient;

  ViewSystem(const std::vector<double>& wanted, std::uint64_t seed) {
    const auto n = static_cast<Eigen::Index>(wanted.size());
    test::Random random(seed);
    Eigen::MatrixXd J(3 * n, n);
    for (double& value : J.reshaped()) value = random.Normal();
    const Eigen::MatrixXd H = J.transpose() * J;
    const Eigen::VectorXd g = -H * Eigen::Map<const Eigen::VectorXd>(wanted.data(), n);
    curvature.assign(H.data(), H.data() + H.size());
    gradient.assign(g.begin(), g.end());
  }
};

// With the lens's numbers last.
std::vector<double> Wanted(const FreeUnknowns& free, const LensStepNumbers& lens, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<double> wanted;
  for (int k = 0; k < free.OwnOfView().num_tangent(); ++k) wanted.push_back(0.1 * random.Normal());
  wanted.insert(wanted.end(), lens.v, lens.v + free.lens_tangent());
  return wanted;
}

// Three views of one lens, each with another pose: what is wanted of the lens comes out of all of them together, and
// of each view's own numbers from its step and from what follows the lens.
TEST(LensStep, IsGaussNewtonsOfAllUnknownsTogether) {
  for (const FreeUnknowns& free : {kAll, FreeUnknowns{.pose = true, .color = false, .lens = true}}) {
    const LensStepNumbers lens{{0.02, -0.01, 0.03, 0.01}};
    LensSystem system;
    std::vector<ViewSystem> views;
    for (std::uint64_t v = 0; v < 3; ++v) {
      views.emplace_back(Wanted(free, lens, v), 10 + v);
      AddToLens(free, views[v].gradient, views[v].curvature, &system);
    }
    EXPECT_EQ(system.views, 3);
    const LensStepNumbers found = LensStep(free, system, 1, kNoLimit);
    for (int k = 0; k < kLensNumbers; ++k) EXPECT_NEAR(found.v[k], lens.v[k], 5e-4);  // the damping
    for (std::uint64_t v = 0; v < 3; ++v) {
      CameraStepState state;
      state.curvature = views[v].curvature;
      const std::vector<double> own = CameraStep({}, free, views[v].gradient, {1, kNoLimit.most, 0}, &state),
                                follow = Follow(free, views[v].curvature, found), wanted = Wanted(free, lens, v);
      ASSERT_EQ(own.size(), wanted.size());
      ASSERT_EQ(follow.size(), wanted.size());
      for (std::size_t i = 0; i < wanted.size(); ++i) EXPECT_NEAR(own[i] + follow[i], wanted[i], 2e-3) << i;
    }
    const LensStepNumbers half = LensStep(free, system, 0.5, kNoLimit), near = LensStep(free, system, 1, {0.003, 0.5});
    for (int k = 0; k < kLensNumbers; ++k) {
      EXPECT_NEAR(half.v[k], found.v[k] / 2, 1e-15);
      EXPECT_NEAR(near.v[k], found.v[k] * 0.003 / found.v[2], 1e-6) << "the largest has the limit";
    }
  }
}

// Coefficients are held back, the more so the less they can be told from what else is free, and still come to where the
// cost is least.
TEST(LensStep, BringsCoefficientsInSomeSteps) {
  const LensStepNumbers lens{{0.02, -0.01, 0.03, 0.01, -0.02, 0.015}};
  std::vector<ViewSystem> views;
  std::vector<std::vector<double>> wanted;
  for (std::uint64_t v = 0; v < 3; ++v) {
    wanted.push_back(Wanted(kBentToo, lens, v));
    views.emplace_back(wanted.back(), 10 + v);
  }
  LensStepNumbers found;
  double first = 0;
  for (int round = 0; round < 60; ++round) {
    LensSystem system;
    for (std::size_t v = 0; v < views.size(); ++v) {
      const auto n = static_cast<Eigen::Index>(wanted[v].size());
      Eigen::VectorXd off = -Eigen::Map<const Eigen::VectorXd>(wanted[v].data(), n);
      for (int k = 0; k < kLensNumbers; ++k) off[n - kLensNumbers + k] += found.v[k];
      const Eigen::VectorXd g = Eigen::Map<const Eigen::MatrixXd>(views[v].curvature.data(), n, n) * off;
      AddToLens(kBentToo, {g.begin(), g.end()}, views[v].curvature, &system);
    }
    const LensStepNumbers step = LensStep(kBentToo, system, 1, kNoLimit);
    for (int k = 0; k < kLensNumbers; ++k) found.v[k] += step.v[k];
    if (round == 0) first = found.v[4];
  }
  EXPECT_GT(std::abs(first - lens.v[4]), 1e-3);
  for (int k = 0; k < kLensNumbers; ++k) EXPECT_NEAR(found.v[k], lens.v[k], 1e-4) << k;
}

// What coefficients do goes by the third and the fifth power of the distance from the principal point.
TEST(LensStep, BendsNoCornerFartherThanTheLimit) {
  LensSystem system;
  const std::vector<double> wanted = Wanted(kBentToo, {{0, 0, 0, 0, 0.2, -0.1}}, 3);
  const ViewSystem view(wanted, 4);
  AddToLens(kBentToo, view.gradient, view.curvature, &system);
  const LensStepNumbers whole = LensStep(kBentToo, system, 1, {0.1, 0.5}),
                        near = LensStep(kBentToo, system, 1, {0.1, 2});
  EXPECT_NEAR(whole.v[4], 0.2, 0.05);
  EXPECT_NEAR(near.v[5] * 32, -0.1, 1e-12);
  EXPECT_NEAR(near.v[4] / near.v[5], whole.v[4] / whole.v[5], 1e-9);
}

TEST(LensStep, StaysWhereNothingIsKnown) {
  const LensSystem nothing;
  for (const double value : LensStep(kBentToo, nothing, 1, {}).v) EXPECT_EQ(value, 0);
  LensSystem system;
  std::vector<double> gradient(16, 1);
  gradient[3] = std::numeric_limits<double>::quiet_NaN();
  AddToLens(kAll, gradient, ViewSystem(Wanted(kAll, {}, 1), 2).curvature, &system);
  EXPECT_EQ(system.views, 0);
  EXPECT_THROW(AddToLens(kAll, gradient, std::vector<double>(144, 1), &system), Error);
  std::vector<double> no_numbers = ViewSystem(Wanted(kAll, {}, 1), 2).curvature;
  no_numbers[12 * 16] = std::numeric_limits<double>::quiet_NaN();  // of the lens with the pose
  const LensStepNumbers lens{{0.1, 0.1, 0, 0}};
  const std::vector<double> follow = Follow(kAll, no_numbers, lens);
  for (int k = 0; k < kAll.OwnOfView().num_tangent(); ++k) EXPECT_EQ(follow[static_cast<std::size_t>(k)], 0);
}

TEST(LensChange, IsOfTheGivenLensAndComposes) {
  const splat::Lens given{100, 120, 50, 40};
  EXPECT_TRUE(LensChange{}.Of(given) == given);
  const LensChange change = Compose({{0.1, 0.2, 0.01, -0.02}}, {});
  const splat::Lens lens = change.Of(given);
  EXPECT_NEAR(lens.fx, 100 * std::exp(0.1), 1e-12);
  EXPECT_NEAR(lens.cy, 40 - 0.02 * 120, 1e-12);
  // A second step is of the lens as it is then.
  const splat::Lens twice = Compose({{0, 0, 0.05, 0}}, change).Of(given);
  EXPECT_NEAR(twice.cx, lens.cx + 0.05 * lens.fx, 1e-12);
  // A bend leaves the pinhole; a second one adds to it.
  const LensChange bent = Compose({{0, 0, 0, 0, 0.02, -0.01}}, Compose({{0, 0, 0, 0, 0.1, 0.2}}, {}));
  EXPECT_TRUE(bent.Of(given) == given);
  EXPECT_FALSE(bent.is_none());
  EXPECT_TRUE(bent.is_bend_sound(1));
  EXPECT_NEAR(bent.radial[0], 0.12, 1e-15);
  EXPECT_NEAR(bent.radial[1], 0.19, 1e-15);
  EXPECT_TRUE(Compose({{0, 0, 0, 0, 0, 50}}, {}).is_bend_sound(0.25)) << "a long lens";
  EXPECT_FALSE(bent.is_bend_sound(1.5));
  EXPECT_FALSE(Compose({{0, 0, 0, 0, -0.4, 0}}, {}).is_bend_sound(1)) << "it folds";
  EXPECT_FALSE(Compose({{0, 0, 0, 0, NAN, 0}}, {}).is_bend_sound(1));
  // And the same of a smaller image.
  const splat::Lens small = change.Of(given.Scaled(0.5, 0.5));
  EXPECT_NEAR(small.cx, lens.cx / 2, 1e-12);
  EXPECT_NEAR(small.fy, lens.fy / 2, 1e-12);
}

}  // namespace
}  // namespace vesta::gs
