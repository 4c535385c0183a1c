// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "apps/viewer/frame_renderer.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/test_files.h"

namespace vesta::app {
namespace {

class FrameRequests : public testing::Test {
 protected:
  FrameRequests() { gs::test::RenderTruth(gs::test::RandomModel(20, 0, 1), 0, &scene_); }

  static HttpQuery Free() {
    return {{"kind", "render"},    {"width", "64"},         {"height", "32"},
            {"position", "1,2,3"}, {"rotation", "2,0,0,0"}, {"focal", "1.5"}};
  }
  static HttpQuery OfPhoto(const std::string& kind) {
    return {{"kind", kind}, {"width", "80"}, {"height", "60"}, {"photo", "2"}};
  }
  auto Asking(HttpQuery query, const std::string& name, const std::string& value) const {
    query[name] = value;
    return [this, query] { ParseFrameRequest(query, scene_); };
  }

  gs::Scene scene_ = gs::test::RingOfCameras(4, 40, 30, false);
};

TEST_F(FrameRequests, OfAFreeCamera) {
  HttpQuery query = Free();
  const double half = std::sqrt(0.5);  // rotated by 90 degrees about y: looks along world x
  query["rotation"] = fmt::format("{},0,{},0", half, half);
  const FrameRequest request = ParseFrameRequest(query, scene_);
  EXPECT_EQ(request.kind, FrameKind::kRender);
  EXPECT_FALSE(request.photo);
  const gs::View& view = request.view;
  EXPECT_EQ(view.camera.width, 64);
  EXPECT_EQ(view.camera.height, 32);
  EXPECT_EQ(view.camera.lens.fx, 48);
  EXPECT_EQ(view.camera.lens.cx, 32);
  const auto centre = gs::CameraCenter(view);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(centre[i], static_cast<double>(i) + 1, 1e-12);
  const auto ahead = gs::InCamera(view, {11, 2, 3});
  EXPECT_NEAR(ahead[0], 0, 1e-12);
  EXPECT_NEAR(ahead[1], 0, 1e-12);
  EXPECT_NEAR(ahead[2], 10, 1e-12);
}

// At most the photograph's resolution.
TEST_F(FrameRequests, OfAPhotograph) {
  const FrameRequest render = ParseFrameRequest(OfPhoto("render"), scene_);
  EXPECT_EQ(render.photo, 2u);
  EXPECT_EQ(render.view.camera.width, 80);
  EXPECT_EQ(render.view.camera.lens.fx, 2 * scene_.views[2].camera.lens.fx);
  EXPECT_EQ(render.view.rotation, scene_.views[2].rotation);
  EXPECT_EQ(render.view.translation, scene_.views[2].translation);
  for (const char* kind : {"truth", "difference"}) {
    const FrameRequest request = ParseFrameRequest(OfPhoto(kind), scene_);
    EXPECT_EQ(request.view.camera.width, 40) << kind;
    EXPECT_EQ(request.view.camera.height, 30) << kind;
  }
}

TEST_F(FrameRequests, RefusesWhatIsNoNumberOrTooMuch) {
  const std::pair<const char*, const char*> bad[] = {{"kind", "../../etc/passwd"},
                                                     {"width", "15"},
                                                     {"width", "4097"},
                                                     {"height", "nan"},
                                                     {"height", "1e9"},
                                                     {"position", "1,2"},
                                                     {"position", "1,2,inf"},
                                                     {"position", "nan,0,0"},
                                                     {"position", "1e300,0,0"},
                                                     {"rotation", "0,0,0,0"},
                                                     {"rotation", "1"},
                                                     {"focal", "0"},
                                                     {"focal", "-1"},
                                                     {"focal", ""}};
  for (const auto& [name, value] : bad)
    EXPECT_THAT(Asking(Free(), name, value), ThrowsError(kBadArgument, name)) << value;
  for (const char* photo : {"4", "-1", "x", "99999999999999999999"}) {
    EXPECT_THAT(Asking(OfPhoto("render"), "photo", photo), ThrowsError(kBadArgument, "photo")) << photo;
  }
  EXPECT_THAT(Asking(Free(), "kind", "truth"), ThrowsError(kBadArgument, "photo"));
  for (const char* name : {"kind", "width", "height", "position", "rotation", "focal"}) {
    HttpQuery query = Free();
    query.erase(name);
    EXPECT_THAT([&] { ParseFrameRequest(query, scene_); }, ThrowsError(kBadArgument, name));
  }
  scene_.views[2].image = {};
  EXPECT_THAT(Asking(OfPhoto("truth"), "kind", "truth"), ThrowsError(kNotFound, "photo"));
  EXPECT_NO_THROW(ParseFrameRequest(OfPhoto("removal_cost"), scene_));
  scene_.views.clear();
  for (const char* kind : {"removal_cost", "coverage"}) {
    EXPECT_THAT(Asking(Free(), "kind", kind), ThrowsError(kBadArgument, "kind")) << kind;
  }
  EXPECT_THAT(Asking(OfPhoto("render"), "kind", "render"), ThrowsError(kBadArgument, "photo"));
}

}  // namespace
}  // namespace vesta::app
