// SPDX-License-Identifier: Apache-2.0
#include "splatting/pruning/coverage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "kernels/gaussian_splatting/view/splat_view.h"
#include "kernels/math/quaternion.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"

namespace vesta::gs {
namespace {

std::vector<Coverage> Measure(const SplatModel& model, const Scene& scene) {
  return MeasureCoverage(ToKernelModel(model), TrainingViewsOf(scene, {0, 0, 0}));
}

// One Gaussian at height y above the centre.
SplatModel OneAt(double y, double deviation) {
  SplatModel model = test::RandomModel(1, 0, 5);
  for (int k = 0; k < 3; ++k) {
    model.attribute(splat::kMean + k)[0] = k == 1 ? static_cast<float>(y) : 0;
    model.attribute(splat::kLogScale + k)[0] = static_cast<float>(std::log(deviation));
  }
  return model;
}

// `shown` sums the falloff over pixel centres.
TEST(Coverage, ShownIsTheIntegralOfTheFalloff) {
  const Scene scene = test::RingOfCameras(5, 80, 60, false);
  SplatModel model = test::RandomModel(30, 0, 8);
  for (Index i = 0; i < model.count; ++i) model.attribute(splat::kMean)[i] *= 2;  // some lie outside the images
  const ScoringViews scoring_views = TrainingViewsOf(scene, {0, 0, 0});
  std::vector<double> sums(30);
  for (const View* view : scoring_views.views) {
    splat::SplatView<float> splats;
    splat::ViewWorkspace<float> workspace;
    splats.Build(ToKernelModel(model), ToPosedCamera(*view, scoring_views.near), scoring_views.background.data(),
                 workspace);
    for (Index i = 0; i < model.count; ++i) {
      if (splats.rank_of()[i] < 0) continue;
      const splat::Splat<float>& splat = splats.splats()[splats.rank_of()[i]];
      for (int y = 0; y < 60; ++y) {
        for (int x = 0; x < 80; ++x) {
          const float dy = static_cast<float>(y) + 0.5f - splat.v;
          const float p = splat.r * (static_cast<float>(x) + 0.5f - splat.u + splat.beta * dy), q = splat.s * dy;
          sums[static_cast<std::size_t>(i)] += std::exp2(static_cast<double>(-p * p - q * q)) / (80 * 60);
        }
      }
    }
  }
  const std::vector<Coverage> coverage = Measure(model, scene);
  int at_border = 0;
  for (std::size_t i = 0; i < coverage.size(); ++i) {
    EXPECT_NEAR(coverage[i].shown, sums[i], 0.01 * sums[i] + 1e-5) << i;
    at_border += sums[i] > 0 && sums[i] < 3 * coverage[i].body ? 1 : 0;
  }
  EXPECT_GT(at_border, 2) << "Gaussians cut by the image border";
}

TEST(Coverage, BodyIsWhatTheNearestCameraCouldSee) {
  const Scene scene = test::RingOfCameras(4, 80, 60, false);
  constexpr double kFocal = 1.5 * 80, kDistance = 3;
  const double expected = 2 * std::numbers::pi * 0.04 * 0.04 * (kFocal / kDistance) * (kFocal / kDistance) / (80 * 60);
  EXPECT_NEAR(Measure(OneAt(0, 0.04), scene)[0].body, expected, 1e-6 * expected);
  EXPECT_EQ(Measure(OneAt(0, 100), scene)[0].body, 1) << "at most the whole image";
}

TEST(Coverage, WantsWhereNoViewLooks) {
  const Scene scene = test::RingOfCameras(4, 80, 60, false);
  EXPECT_FALSE(Measure(OneAt(0, 0.3), scene)[0].IsUnderObserved()) << "in the middle of the scene";
  // Far outside all images.
  EXPECT_TRUE(Measure(OneAt(4, 0.3), scene)[0].IsUnderObserved());
  EXPECT_FALSE(Measure(OneAt(4, 0.001), scene)[0].IsUnderObserved()) << "too small to hide anything";
}

TEST(Coverage, UnderObservedIsWhatIsMeasuredOfEach) {
  const Scene scene = test::RingOfCameras(5, 80, 60, false);
  SplatModel model = test::RandomModel(200, 2, 8);
  for (Index i = 0; i < model.count; ++i) {
    model.attribute(splat::kMean)[i] *= 4;
    model.attribute(splat::kMean + 1)[i] *= 4;
    // Some of them are small.
    for (int k = 0; k < 3; ++k) model.attribute(splat::kLogScale + k)[i] -= i % 3 == 0 ? 4 : 0;
  }
  const ScoringViews scoring_views = TrainingViewsOf(scene, {0, 0, 0});
  const std::vector<Coverage> coverage = Measure(model, scene);
  const std::vector<bool> under_observed = WhichAreUnderObserved(ToKernelModel(model), scoring_views);
  ASSERT_EQ(under_observed.size(), coverage.size());
  ScoringViews first = scoring_views;
  first.views.resize(1);
  const std::vector<bool> by_first = WhichAreUnderObserved(ToKernelModel(model), first);
  int wanting = 0, small = 0, shown_later = 0;
  for (std::size_t i = 0; i < coverage.size(); ++i) {
    EXPECT_EQ(under_observed[i], coverage[i].IsUnderObserved()) << i;
    wanting += under_observed[i] ? 1 : 0;
    shown_later += by_first[i] && !under_observed[i] ? 1 : 0;
    small += coverage[i].body < 0.003 ? 1 : 0;
  }
  EXPECT_GT(wanting, 5);
  EXPECT_LT(wanting, 150);
  EXPECT_GT(small, 5);
  EXPECT_GT(shown_later, 5);
}

// Many sizes and places, so that coverages are between 0 and more than 1, and some cameras are inside Gaussians.
SplatModel OfManySizes() {
  SplatModel model = test::RandomModel(2000, 1, 9);
  for (Index i = 0; i < model.count; ++i) {
    for (int k = 0; k < 2; ++k) model.attribute(splat::kMean + k)[i] *= 3;
    for (int k = 0; k < 3; ++k) model.attribute(splat::kLogScale + k)[i] += 1.2f * static_cast<float>(i % 4) - 2;
    model.attribute(splat::kLogScale + i % 3)[i] -= 1;  // flat
  }
  return model;
}

// Whether alpha is at least 1/255 at a camera's centre.
bool IsInside(const SplatModel& model, Index i, const Scene& scene) {
  double q[4], R[9];
  for (int k = 0; k < 4; ++k) q[k] = model.attribute(splat::kQuaternion + k)[i];
  RotationFromQuaternion(q, R);
  const double opacity = 1 / (1 + std::exp(-double{model.attribute(splat::kOpacity)[i]}));
  return std::ranges::any_of(scene.views, [&](const View& view) {
    const splat::PosedCamera camera = ToPosedCamera(view, 0.01);
    double exponent = 0;
    for (int k = 0; k < 3; ++k) {
      double along = 0;
      for (int r = 0; r < 3; ++r) along += R[3 * r + k] * (camera.centre[r] - model.attribute(r)[i]);
      exponent += 0.5 * std::pow(along / std::exp(double{model.attribute(splat::kLogScale + k)[i]}), 2);
    }
    return opacity * std::exp(-exponent) >= 1.0 / 255;
  });
}

TEST(Coverage, OfUnderObservedGaussiansIsTheMeasuredOne) {
  const Scene scene = test::RingOfCameras(5, 80, 60, false);
  const SplatModel model = OfManySizes();
  const std::vector<Coverage> measured = Measure(model, scene);
  const std::vector<Coverage> found = CoverageOfUnderObserved(ToKernelModel(model), TrainingViewsOf(scene, {0, 0, 0}));
  ASSERT_EQ(found.size(), measured.size());
  int shown = 0, others = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Coverage expected = measured[i].IsUnderObserved() ? measured[i] : Coverage();
    EXPECT_NEAR(found[i].body, expected.body, 1e-9) << i;
    EXPECT_NEAR(found[i].shown, expected.shown, 1e-6 * expected.shown) << i;
    shown += expected.shown > 0 ? 1 : 0;
    others += measured[i].IsUnderObserved() ? 0 : 1;
  }
  EXPECT_GT(shown, 5);
  EXPECT_GT(others, 100);
}

TEST(Coverage, IsLowBelowAPartOfALargeBody) {
  EXPECT_TRUE((Coverage{.shown = 0.0029, .body = 0.1}.IsUnderObserved()));
  EXPECT_FALSE((Coverage{.shown = 0.0031, .body = 0.1}.IsUnderObserved()));
  EXPECT_TRUE((Coverage{.shown = 0, .body = 0.0031}.IsUnderObserved()));
  EXPECT_FALSE((Coverage{.shown = 0, .body = 0.0029}.IsUnderObserved())) << "small ones hide little";
}

// Shrinks the two longer axes, which the body consists of.
TEST(Coverage, ShrunkGaussiansHaveTheLeastIfTheyAreShownAsBefore) {
  const Scene scene = test::RingOfCameras(5, 80, 60, false);
  const SplatModel model = OfManySizes();
  const std::vector<Coverage> before = Measure(model, scene);
  const std::vector<float> shrinkage = LogShrinkage(ToKernelModel(model), TrainingViewsOf(scene, {0, 0, 0}));
  ASSERT_EQ(shrinkage.size(), before.size());
  SplatModel shrunk = model;
  std::vector<bool> is_flat;  // also afterwards
  for (Index i = 0; i < model.count; ++i) {
    const float by = shrinkage[static_cast<std::size_t>(i)];
    float longer = 1e9f;
    for (int k = 0; k < 3; ++k) {
      if (k == i % 3) continue;
      shrunk.attribute(splat::kLogScale + k)[i] -= by;
      longer = std::min(longer, shrunk.attribute(splat::kLogScale + k)[i]);
    }
    is_flat.push_back(shrunk.attribute(splat::kLogScale + i % 3)[i] < longer);
  }
  const std::vector<Coverage> after = Measure(shrunk, scene);
  const double most = std::log(kMostShrinkage);
  int none = 0, inside = 0, partly = 0, fully = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (IsInside(model, static_cast<Index>(i), scene)) {
      EXPECT_NEAR(shrinkage[i], most, 1e-6) << i;
      ++inside;
    } else if (!before[i].IsUnderObserved()) {
      EXPECT_EQ(shrinkage[i], 0) << i;
      ++none;
    } else if (before[i].body == 1 || !is_flat[i]) {
      EXPECT_GT(shrinkage[i], 0) << i;  // the body is smaller than the product of the longer axes
    } else if (before[i].shown > Coverage::kLeast / (kMostShrinkage * kMostShrinkage) * before[i].body) {
      EXPECT_NEAR(before[i].shown / after[i].body, Coverage::kLeast, 1e-5) << i;
      EXPECT_LT(shrinkage[i], most) << i;
      ++partly;
    } else {
      EXPECT_NEAR(shrinkage[i], most, 1e-6) << i;
      EXPECT_NEAR(after[i].body, before[i].body / (kMostShrinkage * kMostShrinkage), 1e-5 * before[i].body) << i;
      ++fully;
    }
  }
  EXPECT_GT(none, 100);
  EXPECT_GT(inside, 2);
  EXPECT_GT(partly, 5);
  EXPECT_GT(fully, 5);
}

TEST(Coverage, GaussiansOutsideAllImagesShrinkTheMost) {
  const Scene scene = test::RingOfCameras(4, 80, 60, false);
  const ScoringViews scoring_views = TrainingViewsOf(scene, {0, 0, 0});
  const auto shrinkage = [&](double y, double deviation) {
    return LogShrinkage(ToKernelModel(OneAt(y, deviation)), scoring_views)[0];
  };
  EXPECT_FLOAT_EQ(shrinkage(9, 0.3), std::log(static_cast<float>(kMostShrinkage))) << "never shown";
  EXPECT_EQ(shrinkage(0, 0.3), 0) << "in the middle of the scene";
  EXPECT_EQ(shrinkage(9, 0.001), 0) << "too small to hide anything";
}

// All cameras are at distance 3 from the origin.
TEST(Coverage, GaussiansAroundACameraShrinkTheMost) {
  const Scene scene = test::RingOfCameras(4, 80, 60, false);
  const ScoringViews scoring_views = TrainingViewsOf(scene, {0, 0, 0});
  const auto shrinkage = [&](std::array<double, 3> scales, double opacity, std::array<float, 4> q) {
    SplatModel model = OneAt(0, 1);
    for (int k = 0; k < 3; ++k) {
      model.attribute(splat::kMean + k)[0] = 0;
      model.attribute(splat::kLogScale + k)[0] = static_cast<float>(std::log(scales[static_cast<std::size_t>(k)]));
    }
    for (int k = 0; k < 4; ++k) model.attribute(splat::kQuaternion + k)[0] = q[static_cast<std::size_t>(k)];
    model.attribute(splat::kOpacity)[0] = static_cast<float>(std::log(opacity / (1 - opacity)));
    EXPECT_FALSE(Measure(model, scene)[0].IsUnderObserved());
    return LogShrinkage(ToKernelModel(model), scoring_views)[0];
  };
  const std::array<float, 4> none = {1, 0, 0, 0}, quarter_turn = {1, 0, 0, 1};  // about z
  const float most = std::log(static_cast<float>(kMostShrinkage));
  // With an opacity of 0.5, alpha is 1/255 at 3.114 standard deviations.
  EXPECT_FLOAT_EQ(shrinkage({0.97, 0.97, 0.97}, 0.5, none), most);
  EXPECT_EQ(shrinkage({0.95, 0.95, 0.95}, 0.5, none), 0);
  EXPECT_EQ(shrinkage({0.97, 0.97, 0.97}, 0.4, none), 0);
  // The first camera is on the x axis, no camera near the y axis.
  EXPECT_FLOAT_EQ(shrinkage({2, 0.2, 0.2}, 0.5, none), most);
  EXPECT_EQ(shrinkage({2, 0.2, 0.2}, 0.5, quarter_turn), 0);
  EXPECT_FLOAT_EQ(shrinkage({0.2, 2, 0.2}, 0.5, quarter_turn), most);
}

constexpr Index kCount = 300;

// A ball in which Gaussian 7 is at distance y from the centre, with this deviation and opacity.
SplatModel WithOneAt(double y, double deviation, double opacity) {
  SplatModel model = test::RandomModel(kCount, 0, 4);
  for (int k = 0; k < 3; ++k) {
    model.attribute(splat::kMean + k)[7] = k == 1 ? static_cast<float>(y) : 0;
    model.attribute(splat::kLogScale + k)[7] = static_cast<float>(std::log(deviation));
  }
  model.attribute(splat::kOpacity)[7] = static_cast<float>(std::log(opacity / (1 - opacity)));
  return model;
}

bool Keeps(const FloaterCount& count, Index i) { return std::ranges::find(count.kept, i) != count.kept.end(); }

TEST(Floaters, ABallOfGaussiansHasNone) {
  const FloaterCount count = FindFloaters(test::RandomModel(kCount, 0, 4), nullptr);
  EXPECT_EQ(count.kept.size(), static_cast<std::size_t>(kCount));
  EXPECT_TRUE(std::ranges::is_sorted(count.kept));
}

TEST(Floaters, FaintIsWhatIsNeverDrawn) {
  EXPECT_EQ(FindFloaters(WithOneAt(0.1, 0.1, 1.01 / 255), nullptr).faint, 0);
  const FloaterCount count = FindFloaters(WithOneAt(0.1, 0.1, 0.99 / 255), nullptr);
  EXPECT_EQ(count.faint, 1);
  EXPECT_FALSE(Keeps(count, 7));
  EXPECT_EQ(count.kept.size(), static_cast<std::size_t>(kCount - 1));
}

TEST(Floaters, HugeIsWhatReachesAroundAll) {
  EXPECT_EQ(FindFloaters(WithOneAt(0, 0.3, 0.5), nullptr).huge, 0);
  const FloaterCount count = FindFloaters(WithOneAt(0, 2, 0.5), nullptr);
  EXPECT_EQ(count.huge, 1);
  EXPECT_FALSE(Keeps(count, 7));
  // Large but far away, like a sky: kept.
  EXPECT_EQ(FindFloaters(WithOneAt(50, 20, 0.5), nullptr).huge, 0);
}

TEST(Floaters, IsolatedIsFarFromAllForItsSize) {
  EXPECT_EQ(FindFloaters(WithOneAt(0.9, 0.05, 0.5), nullptr).isolated, 0);
  const FloaterCount count = FindFloaters(WithOneAt(6, 0.05, 0.5), nullptr);
  EXPECT_EQ(count.isolated, 1);
  EXPECT_FALSE(Keeps(count, 7));
  EXPECT_EQ(FindFloaters(WithOneAt(6, 2, 0.5), nullptr).isolated, 0) << "it overlaps the others";
}

TEST(Floaters, UnsupportedIsWhatNoViewShows) {
  const Scene scene = test::RingOfCameras(6, 60, 40, false);
  const ScoringViews scoring_views = TrainingViewsOf(scene, {0, 0, 0});
  EXPECT_EQ(FindFloaters(test::RandomModel(kCount, 0, 4), &scoring_views).under_observed, 0);
  const SplatModel model = WithOneAt(4.5, 0.9, 0.5);  // above all images
  EXPECT_EQ(FindFloaters(model, nullptr).kept.size(), static_cast<std::size_t>(kCount));
  const FloaterCount count = FindFloaters(model, &scoring_views);
  EXPECT_EQ(count.under_observed, 1);
  EXPECT_FALSE(Keeps(count, 7));
}

TEST(Floaters, FewGaussiansOrAllAtOnePlaceAreNoError) {
  for (const Index gaussians : {Index{1}, Index{2}, Index{5}}) {
    SplatModel model = test::RandomModel(gaussians, 0, 4);
    std::fill_n(model.data.begin(), 3 * gaussians, 1.0f);  // the means
    EXPECT_EQ(FindFloaters(model, nullptr).kept.size(), static_cast<std::size_t>(gaussians));
  }
  SplatModel faint = test::RandomModel(3, 0, 4);
  std::fill_n(faint.attribute(splat::kOpacity), 3, -20.0f);
  EXPECT_TRUE(FindFloaters(faint, nullptr).kept.empty());
}

}  // namespace

}  // namespace vesta::gs
