// SPDX-License-Identifier: Apache-2.0
// Each warning of vesta doctor, caused by one defect in an otherwise good scene.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "apps/doctor/exposures.h"
#include "apps/doctor/scene_warnings.h"
#include "kernels/gaussian_splatting/lenses/models.h"
#include "tests/apps/run_program.h"
#include "tests/apps/tiny_scene.h"

namespace vesta::app {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

constexpr int kSize = 48;

// Details of a few pixels, different in each view.
gs::Image Picture(int view) {
  gs::Image image(kSize, kSize);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const double value = 0.45 + 0.2 * std::sin(1.3 * x + 0.4 * view) * std::cos(1.1 * y - 0.7 * view) +
                             0.1 * std::sin(0.2 * x + 0.5 * view + c);
        image.plane(c)[y * kSize + x] = static_cast<float>(value);
      }
    }
  }
  return image;
}

// Twelve views side by side, with 600 points in front.
gs::Scene SoundScene() {
  gs::Scene scene;
  for (int i = 0; i < 12; ++i) {
    gs::View view;
    view.name = fmt::format("{:02}.png", i);
    view.camera = {kSize, kSize, {40, 40, kSize / 2.0, kSize / 2.0}};
    view.translation = {0.1 * i - 0.5, 0, 4};
    view.image = Picture(i);
    scene.views.push_back(view);
  }
  for (int i = 0; i < 600; ++i) {
    scene.points.positions.push_back({static_cast<float>(std::sin(1.0 * i)),
                                      static_cast<float>(0.7 * std::sin(2.3 * i)),
                                      static_cast<float>(0.5 * std::cos(3.1 * i))});
    scene.points.colors.push_back({0.5f, 0.5f, 0.5f});
  }
  return scene;
}

void Change(gs::Image* image, const std::function<float(float)>& of) {
  for (float& value : image->rgb) value = of(value);
}

TEST(SceneWarnings, SoundSceneHasNone) { EXPECT_THAT(SceneWarnings(SoundScene()), IsEmpty()); }

TEST(SceneWarnings, FewViewsAndPoints) {
  gs::Scene scene = SoundScene();
  scene.views.resize(5);
  scene.points.positions.resize(40);
  EXPECT_THAT(SceneWarnings(scene), ElementsAre(StartsWith("only 5 views"), StartsWith("only 40 points")));
}

TEST(SceneWarnings, ViewThatLooksAway) {
  gs::Scene scene = SoundScene();
  scene.views[3].rotation = {-1, 0, 0, 0, 1, 0, 0, 0, -1};  // rotated by 180 degrees
  scene.views[3].translation = {0.2, 0, -4};
  EXPECT_THAT(SceneWarnings(scene), ElementsAre(HasSubstr("03.png: sees only 0 of the points")));
}

TEST(SceneWarnings, SamePhotographAndSamePose) {
  gs::Scene scene = SoundScene();
  scene.views[7].image = scene.views[2].image;
  scene.views[9].translation = scene.views[4].translation;
  EXPECT_THAT(SceneWarnings(scene), ElementsAre(HasSubstr("09.png: has the same pose as 04.png"),
                                                HasSubstr("07.png: nearly the same photograph as 02.png")));
}

TEST(SceneWarnings, BlurredPhotograph) {
  gs::Scene scene = SoundScene();
  const gs::Image sharp = scene.views[5].image;
  gs::Image& blurred = scene.views[5].image;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {  // mean over 9 x 9
        float sum = 0;
        for (int dy = -4; dy <= 4; ++dy) {
          for (int dx = -4; dx <= 4; ++dx) {
            const int at_y = std::clamp(y + dy, 0, kSize - 1), at_x = std::clamp(x + dx, 0, kSize - 1);
            sum += sharp.plane(c)[at_y * kSize + at_x] / 81;
          }
        }
        blurred.plane(c)[y * kSize + x] = sum;
      }
    }
  }
  EXPECT_THAT(SceneWarnings(scene), ElementsAre(HasSubstr("05.png: blurred?")));
}

TEST(SceneWarnings, ExposureThatDiffers) {
  gs::Scene scene = SoundScene();
  Change(&scene.views[1].image, [](float value) { return 0.6f * value; });
  Change(&scene.views[8].image, [](float value) { return 1.55f * value; });
  // Other content is not another exposure.
  for (float& value : scene.views[4].image.rgb) value = value > 0.6f ? 0.1f : value;
  EXPECT_THAT(SceneWarnings(scene),
              ElementsAre(testing::MatchesRegex("01.png: 1.[5-9] stops darker than the others"),
                          testing::MatchesRegex("08.png: 1.[1-6] stops lighter than the others")));
}

// A scene whose photographs show the points in their colours, times a gain per view. Every third point is hidden in
// every other view, and dark there; the tracks know it.
struct ExposedScene {
  explicit ExposedScene(const std::vector<double>& gains) : scene(SoundScene()), tracks(scene.points.positions.size()) {
    for (std::size_t i = 0; i < scene.views.size(); ++i) {
      gs::View& view = scene.views[i];
      view.id = static_cast<std::uint32_t>(100 + i);
      for (std::size_t p = 0; p < scene.points.positions.size(); ++p) {
        const auto& at = scene.points.positions[p];
        const bool is_hidden = p % 3 == 0 && i % 2 == 0;
        if (!(gs::DepthInView(view, at) > 0)) continue;
        const auto t = gs::InCamera(view, {at[0], at[1], at[2]});
        double u = 0, v = 0;
        splat::PixelOf(view.camera.lens, t.data(), u, v);
        const std::size_t pixel = static_cast<std::size_t>(v) * kSize + static_cast<std::size_t>(u);
        const double brightness = is_hidden ? 0.1 : gains[i] * (0.3 + 0.05 * static_cast<double>(p % 5));
        for (int c = 0; c < 3; ++c) view.image.plane(c)[pixel] = static_cast<float>(brightness);
        if (!is_hidden) tracks[p].push_back(view.id);
      }
    }
  }
  gs::Scene scene;
  gs::PointTracks tracks;
};

TEST(ExposureStops, TracksGiveTheGainsOfViewsThatHidePoints) {
  std::vector<double> gains(12);
  for (std::size_t i = 0; i < gains.size(); ++i) gains[i] = 0.9 + 0.2 * static_cast<double>(i * 5 % 12) / 11;
  const ExposedScene exposed(gains);
  const std::vector<double> stops = ExposureStops(exposed.scene, exposed.tracks);
  std::vector<double> sorted = gains;
  std::ranges::sort(sorted);
  ASSERT_EQ(stops.size(), gains.size());
  for (std::size_t i = 0; i < gains.size(); ++i) {
    EXPECT_NEAR(std::exp2(stops[i] / 2.2), gains[i] / sorted[6], 0.02) << "view " << i;
  }
  EXPECT_NEAR(ExposureSpread(stops), sorted[10] / sorted[1] - 1, 0.03);
  EXPECT_THAT(SceneWarnings(exposed.scene, exposed.tracks), testing::Contains(HasSubstr("exposures")));
  const ExposedScene equal(std::vector<double>(12, 1.0));
  EXPECT_LT(ExposureSpread(ExposureStops(equal.scene, equal.tracks)), 0.02);
}

TEST(ExposureStops, UnknownViewsAndFewPointsAreNoEstimate) {
  ExposedScene exposed(std::vector<double>(12, 1.0));
  exposed.scene.views[3].id = 7;  // in no track
  for (auto& track : exposed.tracks) track.push_back(4'000'000'000U);
  const std::vector<double> stops = ExposureStops(exposed.scene, exposed.tracks);
  EXPECT_TRUE(std::isnan(stops[3]));
  EXPECT_FALSE(std::isnan(stops[4]));
  EXPECT_TRUE(std::isnan(ExposureSpread({std::nan(""), 1.0})));
}

TEST(SceneWarnings, OfOneColorAndBurnt) {
  gs::Scene scene = SoundScene();
  Change(&scene.views[0].image, [](float) { return 0.4f; });
  Change(&scene.views[6].image, [](float value) { return value > 0.5f ? 1.0f : value; });
  EXPECT_THAT(SceneWarnings(scene), ElementsAre(StartsWith("00.png: has a single colour"), HasSubstr("06.png: ")));
}

TEST(SceneWarnings, TellsTheFirstFew) {
  gs::Scene scene = SoundScene();
  for (std::size_t i = 1; i < 12; ++i) scene.views[i].image = scene.views[0].image;
  const std::vector<std::string> doubts = SceneWarnings(scene);
  ASSERT_EQ(doubts.size(), 6u);
  EXPECT_EQ(doubts[5], "and 6 more photographs that are nearly the same as another");
}

TEST(ViewDiagnostics, ContrastDoesNotChangeSharpness) {
  const gs::Image image = Picture(0);
  gs::Image pale = image;
  Change(&pale, [](float value) { return 0.4f + 0.3f * value; });
  EXPECT_NEAR(DiagnosticsOf(pale).sharpness / DiagnosticsOf(image).sharpness, 1, 1e-3);
  EXPECT_EQ(ThumbnailDistance(DiagnosticsOf(image), DiagnosticsOf(image)), 0);
  EXPECT_EQ(DiagnosticsOf(gs::Image(1, 1)).sharpness, 0);
  EXPECT_EQ(DiagnosticsOf(gs::Image(3, 2)).thumbnail.size(), 3u * kThumbnail * kThumbnail);
}

TEST(Doctor, SaysWhatASceneIsAndTakes) {
  const TempFolder folder;
  test::WriteTinyScene(folder / "scene");
  const test::ProgramOutput output = test::RunProgram({"doctor", folder / "scene"});
  EXPECT_EQ(output.status, 0) << output.err;
  EXPECT_EQ(output.err, "");
  EXPECT_THAT(output.out,
              HasSubstr("a COLMAP model, 10 photographs of 32 x 24 pixels, horizontal field of view 44 degrees"));
  EXPECT_THAT(output.out, HasSubstr("8 training views, 2 test views (every 8th); 60 points"));
  EXPECT_THAT(output.out, HasSubstr("only 60 points"));
  EXPECT_THAT(
      output.out,
      testing::ContainsRegex(
          "A training run with --preset=balanced takes 4000 iterations: about [0-9:]+ on this machine, [0-9]+ MiB"));
  EXPECT_EQ(test::RunProgram({"doctor", folder / "nowhere"}).status, 1);
}

}  // namespace
}  // namespace vesta::app
