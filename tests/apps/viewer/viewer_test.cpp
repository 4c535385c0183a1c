// SPDX-License-Identifier: Apache-2.0
// The viewer's HTTP interface, as its page uses it.
#include "apps/viewer/viewer.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pthread.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/image.h"
#include "splatting/cameras/unknowns/moved_view.h"
#include "splatting/evaluate/evaluation.h"
#include "splatting/io/images/image_codecs.h"
#include "splatting/pruning/scoring_views.h"
#include "splatting/render/surface.h"
#include "splatting/train/trainer.h"
#include "tests/apps/viewer/http_get.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/test_files.h"

namespace vesta::app {
namespace {

using nlohmann::json;
using test::Ask;
using test::Request;
using testing::HasSubstr;

// "http://127.0.0.1:PORT/?token=TOKEN"
struct Link {
  explicit Link(const std::string& link)
      : port(std::stoi(link.substr(link.rfind(':') + 1))), token(link.substr(link.rfind('=') + 1)) {}
  int port;
  std::string token;
};

class ViewerTest : public testing::Test {
 protected:
  ViewerTest() {
    for (gs::View& view : scene_.views) view.camera.lens.cx = 20, view.camera.lens.cy = 15;  // as in a free camera
    gs::test::RenderTruth(model_, 0, &scene_);
    shown_.Put(std::make_shared<const gs::SplatModel>(model_));
  }
  test::Reply Get(const std::string& target) const {
    const Link link(viewer_.link());
    return Ask(link.port, Request("GET", target, link.token));
  }
  gs::Image Picture(const std::string& query) const {
    const test::Reply reply = Get("/frame?width=40&height=30&" + query);
    EXPECT_EQ(reply.status, 200) << reply.body;
    return ToPlanes(gs::DecodeJpeg("frame", reply.body, false), {});
  }

  gs::SplatModel model_ = gs::test::RandomModel(60, 1, 7);
  gs::Scene scene_ = gs::test::RingOfCameras(9, 40, 30, true);
  ShownModel shown_;
  Viewer viewer_{{}, scene_, {0, 0, 0}, shown_};
};

double MeanDifference(const gs::Image& a, const gs::Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i)
    sum += std::abs(static_cast<double>(a.rgb[i]) - static_cast<double>(b.rgb[i]));
  return sum / static_cast<double>(a.rgb.size());
}

TEST_F(ViewerTest, ThePageIsForWhoHasTheLink) {
  const Link link(viewer_.link());
  const test::Reply page = Ask(link.port, Request("GET", "/?token=" + link.token, ""));
  EXPECT_EQ(page.status, 200);
  EXPECT_THAT(page.body, HasSubstr("<!DOCTYPE html>"));
  EXPECT_THAT(page.headers, HasSubstr("Content-Security-Policy: default-src 'none'"));
  EXPECT_EQ(Ask(link.port, Request("GET", "/", "")).status, 403);
  EXPECT_EQ(Ask(link.port, Request("GET", "/?token=", "")).status, 403);
  EXPECT_EQ(Ask(link.port, Request("GET", "/page.js", "")).status, 200);
  for (const char* target : {"/state", "/scene", "/frame?kind=render&width=40&height=30&photo=0"}) {
    EXPECT_EQ(Ask(link.port, Request("GET", target, "")).status, 403) << target;
    EXPECT_EQ(Ask(link.port, Request("GET", target, std::string(32, '0'))).status, 403) << target;
    // A token in the URL is accepted only for the page, because forms of foreign pages can send URLs too.
    const std::string linked =
        std::string(target) + (std::string(target).find('?') < 99 ? "&" : "?") + "token=" + link.token;
    EXPECT_EQ(Ask(link.port, Request("GET", linked, "")).status, 403) << linked;
    EXPECT_EQ(Get(target).status, 200) << target;
    EXPECT_EQ(Ask(link.port, Request("GET", target, link.token, "Origin: http://evil.example\r\n")).status, 403);
  }
  EXPECT_EQ(Get("/nothing").status, 404);
  EXPECT_EQ(Ask(link.port, Request("POST", "/state", link.token)).status, 405);
  EXPECT_EQ(Ask(link.port, Request("POST", "/stop", link.token)).status, 404) << "no training is running";
}

TEST_F(ViewerTest, PicturesAreThoseOfTheRasterizer) {
  const gs::Image truth = Picture("kind=truth&photo=1"), render = Picture("kind=render&photo=1");
  EXPECT_LT(MeanDifference(truth, scene_.views[1].image), 0.02) << "up to JPEG compression";
  EXPECT_LT(MeanDifference(render, truth), 0.01) << "the model is the true one";
  EXPECT_GT(MeanDifference(render, Picture("kind=render&photo=4")), 0.02);
  const gs::Image none(40, 30);
  EXPECT_LT(MeanDifference(Picture("kind=difference&photo=1"), none), 0.02);
  EXPECT_GT(MeanDifference(Picture("kind=count&photo=1"), none), 0.02);
  gs::SurfaceRenderer surface(gs::NearPlane(scene_));
  EXPECT_LT(MeanDifference(Picture("kind=depth&photo=1"),
                           gs::DepthColors(surface.Depth(model_, scene_.views[1]), 2 * scene_.extent)),
            0.02);
  EXPECT_LT(MeanDifference(
                Picture("kind=median_depth&photo=1"),
                gs::DepthColors(surface.Depth(model_, scene_.views[1], gs::DepthKind::kMedian), 2 * scene_.extent)),
            0.02);
  EXPECT_LT(MeanDifference(Picture("kind=normals&photo=1"), gs::NormalColors(surface.Normals(model_, scene_.views[1]))),
            0.05)
      << "up to JPEG compression at edges";
  EXPECT_GT(MeanDifference(Picture("kind=normals&photo=1"), Picture("kind=depth&photo=1")), 0.1);

  // The same camera by numbers.
  const json view = json::parse(Get("/scene").body)["views"][1];
  const auto numbers = [](const json& list) {
    std::string text;
    for (const json& x : list) text += (text.empty() ? "" : ",") + x.dump();
    return text;
  };
  const std::string free = "kind=render&position=" + numbers(view["position"]) +
                           "&rotation=" + numbers(view["rotation"]) + "&focal=" + view["focal"].dump();
  EXPECT_LT(MeanDifference(Picture(free), render), 0.01);
  EXPECT_EQ(Get("/frame?kind=render&width=40&height=30").status, 400);
}

// The page gets status 202 while values are measured.
TEST_F(ViewerTest, ValuesAreColoursOfTheGaussians) {
  const splat::Model<float> kernel_model = gs::ToKernelModel(model_);
  const gs::ScoringViews scoring_views = gs::TrainingViewsOf(scene_, {0, 0, 0});
  const std::pair<const char*, std::vector<float>> kinds[] = {
      {"removal_cost", RemovalCostColors(gs::MeasureRemovalCost(kernel_model, scoring_views).rise)},
      {"coverage", CoverageColors(gs::MeasureCoverage(kernel_model, scoring_views))}};
  for (const auto& [kind, scale_positions] : kinds) {
    const std::string query = fmt::format("/frame?width=40&height=30&photo=1&kind={}", kind);
    test::Reply reply = Get(query);
    while (reply.status == 202) {
      EXPECT_THAT(reply.body, HasSubstr("being computed"));
      reply = Get(query);
    }
    gs::SplatModel colored = model_;
    for (Index i = 0; i < model_.count; ++i) {
      const auto color = gs::OnScale(gs::kVioletToYellow, scale_positions[static_cast<std::size_t>(i)]);
      for (int k = 0; k < 12; ++k) colored.attribute(splat::kSh + k)[i] = 0;
      for (int c = 0; c < 3; ++c) {
        colored.attribute(splat::kSh + c)[i] = (color[static_cast<std::size_t>(c)] - 0.5f) / 0.28209479f;
      }
    }
    const gs::Image expected = gs::Renderer({0, 0, 0}, gs::NearPlane(scene_)).Render(colored, scene_.views[1]);
    EXPECT_LT(MeanDifference(ToPlanes(gs::DecodeJpeg("frame", reply.body, false), {}), expected), 0.02) << kind;
  }
}

TEST_F(ViewerTest, ShowsTheNewestModel) {
  EXPECT_EQ(json::parse(Get("/state").body),
            json::parse(R"({"version": 1, "gaussians": 60, "cameras_move": false, "training": null})"));
  const gs::Image before = Picture("kind=render&photo=1");
  shown_.Put(std::make_shared<const gs::SplatModel>(gs::test::RandomModel(30, 1, 8)));
  EXPECT_EQ(json::parse(Get("/state").body)["version"], 2);
  EXPECT_GT(MeanDifference(Picture("kind=render&photo=1"), before), 0.02);
}

// Refined cameras are listed in order, except for test views.
TEST_F(ViewerTest, PhotographsAreSeenFromWhereTheirCamerasStand) {
  const gs::Image before = Picture("kind=render&photo=2");
  std::vector<gs::ViewUnknowns> cameras(7);
  cameras[1].motion.translation[0] = 0.4;  // views 0 and 8 are test views
  for (double& log_focal : cameras[1].lens.log_focal) log_focal = 0.2;
  shown_.Put(std::make_shared<const gs::SplatModel>(model_), cameras);
  const gs::View moved = gs::AsFound(scene_.views[2], cameras[1]);
  const gs::Image expected = gs::Renderer({0, 0, 0}, gs::NearPlane(scene_)).Render(model_, moved);
  EXPECT_LT(MeanDifference(Picture("kind=render&photo=2"), expected), 0.01);
  EXPECT_GT(MeanDifference(before, expected), 0.02);
  EXPECT_LT(MeanDifference(Picture("kind=render&photo=1"), scene_.views[1].image), 0.02) << "this camera has not moved";
  EXPECT_TRUE(json::parse(Get("/state").body)["cameras_move"].get<bool>());
  const json views = json::parse(Get("/scene").body)["views"];
  const auto centre = gs::CameraCenter(moved);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(views[2]["position"][k].get<double>(), centre[k], 1e-12);
  EXPECT_EQ(views[2]["focal"].get<double>(), moved.camera.lens.fy / 30);
  EXPECT_EQ(views[0]["role"], "test");
}

TEST_F(ViewerTest, APortIsOneProgramsAlone) {
  const Link link(viewer_.link());
  EXPECT_THROW(Viewer({"127.0.0.1", link.port}, scene_, {0, 0, 0}, shown_), Error);
  const Viewer second({}, scene_, {0, 0, 0}, shown_);
  EXPECT_NE(Link(second.link()).port, link.port);
  EXPECT_NE(Link(second.link()).token, link.token);
}

// Sets the stack size of new threads.
class StacksOf {
 public:
  explicit StacksOf(std::size_t bytes) {
    pthread_attr_t attributes;
    pthread_getattr_default_np(&before_);
    pthread_getattr_default_np(&attributes);
    pthread_attr_setstacksize(&attributes, bytes);
    EXPECT_EQ(pthread_setattr_default_np(&attributes), 0);
    pthread_attr_destroy(&attributes);
  }
  ~StacksOf() {
    pthread_setattr_default_np(&before_);
    pthread_attr_destroy(&before_);
  }
  StacksOf(const StacksOf&) = delete;
  StacksOf& operator=(const StacksOf&) = delete;

 private:
  pthread_attr_t before_{};
};

TEST_F(ViewerTest, WhereThreadsCannotBeStartedItIsRefused) {
  {
    const StacksOf larger_than_memory(std::size_t{1} << 46);
    EXPECT_THAT([&] { Viewer({}, scene_, {0, 0, 0}, shown_); }, ThrowsError(kUnavailable, "49"));
  }
  const Viewer next({}, scene_, {0, 0, 0}, shown_);
  const Link link(next.link());
  EXPECT_EQ(Ask(link.port, Request("GET", "/state", link.token)).status, 200);
}

// The viewer page controls a training.
TEST(TrainingViewTest, CommandsAndState) {
  gs::Scene scene = gs::test::RingOfCameras(12, 40, 30, true);
  gs::test::RenderTruth(gs::test::RandomModel(60, 1, 7), 0.05, &scene);
  TrainingView view({}, scene, {0, 0, 0});
  const Link link(view.link());
  const auto state = [&] { return json::parse(Ask(link.port, Request("GET", "/state", link.token)).body); };
  const auto command = [&](const std::string& name) {
    EXPECT_EQ(Ask(link.port, Request("POST", "/" + name, "")).status, 403) << name;
    EXPECT_EQ(Ask(link.port, Request("GET", "/" + name, link.token)).status, 405) << name;
    return Ask(link.port, Request("POST", "/" + name, link.token)).status;
  };
  gs::TrainCallbacks callbacks;
  std::vector<std::string> seen;
  // The training thread sends commands, for a fixed order.
  callbacks.progress = [&](const gs::TrainProgress& p) {
    if (p.iteration == 10) {
      EXPECT_EQ(command("pause"), 200);
      EXPECT_EQ(state()["training"]["status"], "paused");
      EXPECT_EQ(command("resume"), 200);
      EXPECT_EQ(state()["training"]["status"], "running");
      EXPECT_EQ(command("checkpoint"), 200);
    }
    if (p.iteration == 11) {
      EXPECT_EQ(state()["training"]["iteration"], 10);
    }
    if (p.iteration == 12) {
      const json now = state();
      EXPECT_GE(now["version"], 1) << "a page is open";
      EXPECT_THAT(now["training"]["message"], HasSubstr("no such folder")) << now;
      EXPECT_EQ(now["training"]["costs"].size(), 11u);
      EXPECT_EQ(command("stop"), 200);
      EXPECT_EQ(state()["training"]["status"], "stopping");
    }
  };
  callbacks.checkpoint.path = "no such folder/checkpoint";
  view.monitor().Follow(&callbacks);
  gs::TrainOptions options;
  options.adam.iterations = 1000;
  const gs::TrainResult result = gs::Train(scene, options, {}, callbacks);
  EXPECT_TRUE(result.stopped);
  view.monitor().End();
  const json now = state();
  EXPECT_EQ(now["training"]["status"], "over");
  EXPECT_EQ(now["training"]["iteration"], 13);
  EXPECT_EQ(now["training"]["train_psnr"].size(), result.history.size());
}

}  // namespace
}  // namespace vesta::app
