// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/unknowns/moved_view.h"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "kernels/core/error.h"
#include "tests/splatting/cameras/perturbed_view.h"

namespace vesta::gs {
namespace {

constexpr double kNear = 0.01;

// A model seen by a camera at distance 3.
class MovingViews : public testing::Test {
 protected:
  SplatModel model_ = test::RandomModel(300, 0, 7);
  View view_ = test::RingOfCameras(3, 160, 120, true).views[1];
};

TEST_F(MovingViews, KeepAllButPoseAndImage) {
  view_.image = Image(160, 120);
  view_.role = ViewRole::kTest;
  const View same = MovedView(view_, {});
  EXPECT_EQ(same.rotation, view_.rotation);
  EXPECT_EQ(same.translation, view_.translation);
  EXPECT_EQ(same.name, view_.name);
  EXPECT_TRUE(same.is_test());
  EXPECT_EQ(same.camera.lens.fx, view_.camera.lens.fx);
  EXPECT_TRUE(same.image.empty());
  EXPECT_NE(MovedView(view_, test::RandomMotion(1, 0, 1)).rotation, view_.rotation);
}

TEST_F(MovingViews, OfASceneAreThoseThatAreTrainedOn) {
  const Scene scene = test::RingOfCameras(9, 40, 30, true);
  std::vector<ViewUnknowns> found(7);
  for (std::size_t i = 0; i < found.size(); ++i) found[i].motion = test::RandomMotion(1, 0.1, i);
  const std::vector<View> views = gs::MovedViews(scene, found), same = gs::MovedViews(scene, {});
  ASSERT_EQ(views.size(), 9U);
  std::size_t next = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const View& view = scene.views[v];
    EXPECT_EQ(same[v].rotation, view.rotation);
    EXPECT_EQ(views[v].rotation, view.is_trained() ? MovedView(view, found[next++].motion).rotation : view.rotation);
  }
  found.pop_back();
  EXPECT_THROW(gs::MovedViews(scene, found), Error);
}

TEST_F(MovingViews, ShiftIsWhatTheImageMovesBy) {
  EXPECT_EQ(MedianShift(model_, view_, view_, kNear), 0);
  splat::PoseTangent aside, turned;
  aside.v[3] = 0.03;  // 1 % of the distance
  EXPECT_NEAR(MedianShift(model_, view_, MovedView(view_, splat::Compose(aside, {})), kNear),
              0.01 * view_.camera.lens.fx, 0.2);
  turned.v[1] = 0.1 * std::numbers::pi / 180;
  EXPECT_NEAR(MedianShift(model_, view_, MovedView(view_, splat::Compose(turned, {})), kNear),
              turned.v[1] * view_.camera.lens.fx, 0.02);
}

TEST_F(MovingViews, ShiftOfWhatIsNotSeenIsNone) {
  const double beyond_all = 10;
  EXPECT_EQ(MedianShift(model_, view_, MovedView(view_, test::RandomMotion(1, 0.1, 2)), beyond_all), 0);
}

}  // namespace
}  // namespace vesta::gs
