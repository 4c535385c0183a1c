// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/gaussian_values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <thread>

#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/cameras/unknowns/moved_view.h"
#include "splatting/pruning/scoring_views.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/test_files.h"

namespace vesta::app {
namespace {

using testing::ElementsAre;
using testing::FloatEq;

TEST(GaussianValuePlaces, AreRelativeToTheMiddle) {
  EXPECT_THAT(RemovalCostColors({-1, 2, 0, 4, 12}), ElementsAre(0, FloatEq(1.0f / 3), 0, 0.5f, 0.75f));
  EXPECT_THAT(RemovalCostColors({-1, 0}), ElementsAre(0, 0));
  EXPECT_THAT(RemovalCostColors({}), ElementsAre());
  EXPECT_THAT(CoverageColors({{0, 0.1}, {0.1, 0.1}, {0.3, 0.1}, {0, 0}}), ElementsAre(0, 0.5f, 0.75f, 0));
}

class GaussianValuesTest : public testing::Test {
 protected:
  // Nine cameras, two of them test views. The last Gaussian is outside all views.
  GaussianValuesTest() {
    gs::test::RenderTruth(model_, 0, &scene_);
    model_.attribute(splat::kMean + 1)[model_.count - 1] = 50;
    Put();
  }
  void Put() { shown_.Put(std::make_shared<const gs::SplatModel>(model_)); }
  // Until the values belong to the current model.
  std::vector<float> Wait(GaussianValue value) {
    for (;;) {
      const auto measured = values_->Get(value, shown_.Get());
      if (measured && measured->of.version == shown_.Get().version) return measured->scale_positions;
      std::this_thread::yield();
    }
  }
  gs::ScoringViews MakeScoringViews() const { return gs::TrainingViewsOf(scene_, {0, 0, 0}); }
  // Replaces the photographs by stored ones that `decode` reads.
  void Store(const std::function<gs::Image(const gs::Image&)>& decode) {
    for (gs::View& view : scene_.views) {
      const auto image = std::make_shared<gs::Image>(std::move(view.image));
      view.image = gs::Image();
      view.stored = std::make_shared<gs::StoredPhotograph>(
          store_, gs::PhotographSource{.decode = [=] { return decode(*image); }, .bytes = 1e6});
    }
  }

  gs::SplatModel model_ = gs::test::RandomModel(40, 1, 7);
  gs::Scene scene_ = gs::test::RingOfCameras(9, 40, 30, true);
  std::shared_ptr<gs::PhotographStore> store_ = std::make_shared<gs::PhotographStore>(1e9);
  ShownModel shown_;
  std::optional<GaussianValues> values_{std::in_place, scene_, std::array<double, 3>{0, 0, 0}};
};

TEST_F(GaussianValuesTest, AreThoseOfTheTrainingViews) {
  EXPECT_EQ(values_->Get(GaussianValue::kRemovalCost, shown_.Get()), nullptr);
  const std::vector<float> worth = Wait(GaussianValue::kRemovalCost), support = Wait(GaussianValue::kCoverage);
  const splat::Model<float> model = gs::ToKernelModel(model_);
  EXPECT_EQ(worth, RemovalCostColors(gs::MeasureRemovalCost(model, MakeScoringViews()).rise));
  EXPECT_EQ(support, CoverageColors(gs::MeasureCoverage(model, MakeScoringViews())));
  EXPECT_EQ(worth.back(), 0);
  EXPECT_EQ(support.back(), 0);
  EXPECT_GT(worth[0], 0);
  EXPECT_GT(support[0], 0.5f) << "visible in all views";
}

TEST_F(GaussianValuesTest, OfANewerModelAreMeasuredAnew) {
  const std::vector<float> before = Wait(GaussianValue::kCoverage);
  model_.attribute(splat::kMean + 1)[0] = 50;
  Put();
  const auto meanwhile = values_->Get(GaussianValue::kCoverage, shown_.Get());
  ASSERT_NE(meanwhile, nullptr) << "values of the earlier model";
  EXPECT_EQ(meanwhile->scale_positions.size(), static_cast<std::size_t>(meanwhile->of.model->count));
  EXPECT_GT(before[0], 0);
  EXPECT_EQ(Wait(GaussianValue::kCoverage)[0], 0);
}

// With refined cameras and exposures: undoing a known perturbation gives the original values.
TEST_F(GaussianValuesTest, AreMeasuredByWhereCamerasStand) {
  const std::vector<float> true_removal_cost = Wait(GaussianValue::kRemovalCost),
                           true_coverage = Wait(GaussianValue::kCoverage);
  std::vector<gs::ViewUnknowns> cameras;
  for (gs::View& view : scene_.views) {
    if (!view.is_trained()) continue;
    const auto off = static_cast<double>(cameras.size()) / 8;
    gs::View elsewhere = view;
    elsewhere.translation[0] += off;
    cameras.emplace_back().motion = gs::MotionBetween(elsewhere, view);
    cameras.back().color.offset = {off, 0, -off};
    const HostSpan<float> values{view.image.rgb.data(), static_cast<Index>(view.image.rgb.size())};
    cameras.back().color.Apply(values);
    view.translation = elsewhere.translation;
  }
  shown_.Put(std::make_shared<const gs::SplatModel>(model_), cameras);
  EXPECT_THAT(Wait(GaussianValue::kRemovalCost), testing::Pointwise(testing::FloatNear(1e-3f), true_removal_cost));
  EXPECT_THAT(Wait(GaussianValue::kCoverage), testing::Pointwise(testing::FloatNear(1e-4f), true_coverage));
}

// The store's decoding order belongs to the training.
TEST_F(GaussianValuesTest, KeepNothingInTheStoreOfTheScene) {
  const std::vector<float> in_memory = Wait(GaussianValue::kRemovalCost);
  Store([](const gs::Image& image) { return image; });
  Put();
  EXPECT_EQ(Wait(GaussianValue::kRemovalCost), in_memory);
  EXPECT_EQ(store_->kept_bytes(), 0);
  EXPECT_EQ(store_->decodings(), 0);
}

TEST_F(GaussianValuesTest, TellOfAPhotographThatIsGone) {
  std::atomic<bool> is_gone{true};
  Store([&](const gs::Image& image) {
    if (is_gone) Fail(kNotFound, "view.jpg: no such image");
    return image;
  });
  EXPECT_THAT([&] { Wait(GaussianValue::kRemovalCost); }, ThrowsError(kUnavailable, "view.jpg"));
  is_gone = false;
  EXPECT_THROW(Wait(GaussianValue::kRemovalCost), Error) << "the same model is not tried again";
  Put();
  EXPECT_EQ(Wait(GaussianValue::kRemovalCost).back(), 0);
}

// Otherwise closing the page of a large scene would wait.
TEST_F(GaussianValuesTest, AreBrokenOff) {
  scene_ = gs::test::RingOfCameras(200, 16, 12, false);
  gs::test::RenderTruth(model_, 0, &scene_);
  std::atomic<int> read{0};
  std::atomic<bool> is_over{false};
  Store([&](const gs::Image& image) {
    ++read;
    while (!is_over) std::this_thread::yield();
    return image;
  });
  values_->Get(GaussianValue::kRemovalCost, shown_.Get());
  while (read == 0) std::this_thread::yield();
  is_over = true;
  values_.reset();
  EXPECT_LT(read, 200);
}

}  // namespace
}  // namespace vesta::app
