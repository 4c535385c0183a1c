// SPDX-License-Identifier: Apache-2.0
// Geometry, images and written files of the demo's scene agree.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <numbers>
#include <string>

#include "demo/scene/bent_rays.h"
#include "demo/scene/camera_path.h"
#include "demo/scene/sfm_points.h"
#include "demo/scene/write_scene.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "splatting/io/scenes/load_scene.h"
#include "tests/support/test_files.h"

namespace vesta::demo {
namespace {

constexpr DemoOptions kSmall{.views = 10, .width = 40, .height = 30, .points = 200};

class DemoSceneTest : public testing::Test {
 protected:
  TempFolder temporary_;
  std::filesystem::path folder_ = temporary_ / "scene";
};

// Pixel position and depth of a world point in a loaded view.
Vec3 Project(const gs::View& view, const Vec3& p) {
  const auto& r = view.rotation;
  const auto& t = view.translation;
  const Vec3 c{r[0] * p.x + r[1] * p.y + r[2] * p.z + t[0], r[3] * p.x + r[4] * p.y + r[5] * p.z + t[1],
               r[6] * p.x + r[7] * p.y + r[8] * p.z + t[2]};
  return {view.camera.lens.fx * c.x / c.z + view.camera.lens.cx, view.camera.lens.fy * c.y / c.z + view.camera.lens.cy,
          c.z};
}

TEST_F(DemoSceneTest, RaysEndOnSurfacesThatFaceThem) {
  const Scene scene = MakeScene();
  std::vector<int> seen(scene.objects.size());
  for (const View& view : CameraPath(8, 40, 30)) {
    for (int pixel = 0; pixel < 40 * 30; ++pixel) {
      const int column = pixel % 40, row = pixel / 40;
      const Vec3 direction = RayDirection(view, column + 0.5, row + 0.5);
      const Hit hit = Intersect(scene, view.position, direction);
      ASSERT_NEAR(Length(hit.normal), 1, 1e-9);
      ASSERT_LT(Dot(hit.normal, direction), 1e-3);
      double clear = RoomDistance(scene, hit.point);
      for (std::size_t k = 0; k < scene.objects.size(); ++k) {
        const double distance = Distance(scene.objects[k], hit.point);
        ASSERT_GT(distance, -2e-4);
        clear = std::min(clear, distance);
        seen[k] += &scene.objects[k].material == hit.material ? 1 : 0;
      }
      ASSERT_NEAR(clear, 0, 2e-4);
    }
  }
  for (std::size_t k = 0; k < seen.size(); ++k) EXPECT_GT(seen[k], 20) << "object " << k << " is hardly visible";
}

TEST_F(DemoSceneTest, LoadsBackWithExactPoses) {
  WriteDemoScene(kSmall, folder_.string());
  const gs::Scene loaded = gs::LoadScene(folder_.string());
  ASSERT_EQ(loaded.views.size(), 10u);
  EXPECT_EQ(loaded.points.size(), 200);
  const Scene scene = MakeScene();
  const std::vector<View> views = CameraPath(10, 40, 30);
  for (std::size_t k = 0; k < views.size(); ++k) {
    const gs::View& view = loaded.views[k];
    EXPECT_EQ(view.is_test(), k % 8 == 0);
    ASSERT_EQ(view.image.width, 40);
    ASSERT_EQ(view.image.height, 30);
    for (const auto& [u, v] : {std::pair{0.5, 0.5}, {39.5, 0.5}, {20.0, 15.0}, {7.5, 29.5}}) {
      const Hit hit = Intersect(scene, views[k].position, RayDirection(views[k], u, v));
      const Vec3 projected = Project(view, hit.point);
      EXPECT_NEAR(projected.x, u, 1e-9);
      EXPECT_NEAR(projected.y, v, 1e-9);
      EXPECT_GT(projected.z, 0);
    }
  }
}

TEST_F(DemoSceneTest, RaysComeFromWhereTheLensShowsThem) {
  DemoOptions options = kSmall;
  options.lens = ParseLens("-0.15,0.03,0.002,-0.001");
  WriteDemoScene(options, folder_.string());
  const gs::Scene loaded = gs::LoadScene(folder_.string());  // as a pinhole with the same focal length
  const Scene scene = MakeScene();
  View view = CameraPath(options.views, options.width, options.height)[3];
  view.lens = options.lens;
  const splat::Lens& pinhole = loaded.views[3].camera.lens;
  for (const auto& [u, v] : {std::pair{0.5, 0.5}, {39.5, 0.5}, {20.0, 15.0}, {7.5, 29.5}}) {
    const Hit hit = Intersect(scene, view.position, RayDirection(view, u, v));
    const Vec3 ideal = Project(loaded.views[3], hit.point);
    const auto [x, y] =
        gs::Distort(options.lens, (ideal.x - pinhole.cx) / pinhole.fx, (ideal.y - pinhole.cy) / pinhole.fy);
    EXPECT_NEAR(view.focal * x + 20, u, 1e-9);
    EXPECT_NEAR(view.focal * y + 15, v, 1e-9);
  }
}

TEST_F(DemoSceneTest, UndistortIsTheInverseOfDistort) {
  const gs::Distortion lens = ParseLens("-0.1,0.02,0.001,-0.002");
  EXPECT_EQ(lens.tangential[1], -0.002);
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {0.5, -0.4}, {-0.7, 0.1}, {0.3, 0.6}}) {
    const auto [u, v] = gs::Distort(lens, x, y);
    const auto back = Undistort(lens, u, v);
    ASSERT_TRUE(back);
    EXPECT_NEAR((*back)[0], x, 1e-11);
    EXPECT_NEAR((*back)[1], y, 1e-11);
  }
  EXPECT_FALSE(Undistort(ParseLens("-0.5"), 0.9, 0.0));  // the distortion folds at radius sqrt(2/3), which maps to 0.54
}

TEST_F(DemoSceneTest, LensesThatAreNoneAreRefused) {
  EXPECT_TRUE(ParseLens("").is_none());
  for (const char* text : {"x", "0.1,", ",", "0.1,0.2,0.3", "1,2,3,4,5", "0.1 0.2", "nan", "inf"})
    EXPECT_THROW(ParseLens(text), Error) << text;
}

TEST_F(DemoSceneTest, AWalkGoesOnceRoundInSmallSteps) {
  const std::vector<View> views = Walk(60, 40, 30);
  double turned = 0;
  for (std::size_t k = 0; k < views.size(); ++k) {
    const View &view = views[k], &next = views[(k + 1) % views.size()];
    EXPECT_LT(Length(next.position - view.position), 0.5);
    EXPECT_GT(Dot(view.cam_from_world.row[2], next.cam_from_world.row[2]), std::cos(0.2));
    turned += std::atan2(view.position.x * next.position.z - view.position.z * next.position.x,
                         view.position.x * next.position.x + view.position.z * next.position.z);
  }
  EXPECT_NEAR(turned, 2 * std::numbers::pi, 1e-9);
}

TEST_F(DemoSceneTest, MasksHideAllOfAPasserBy) {
  DemoOptions options = kSmall;
  WriteDemoScene(options, (folder_ / "empty").string());
  options.passer_by_every = 5;
  WriteDemoScene(options, (folder_ / "busy").string());
  const gs::Scene empty = gs::LoadScene((folder_ / "empty").string());
  const gs::Scene busy = gs::LoadScene((folder_ / "busy").string());
  for (std::size_t k = 0; k < 10; ++k) {
    const gs::Image &before = empty.views[k].image, &after = busy.views[k].image;
    ASSERT_EQ(after.mask.empty(), k % 5 != 2);
    if (after.mask.empty()) {
      EXPECT_EQ(before.rgb, after.rgb);
      continue;
    }
    int hidden = 0, changed = 0;
    for (std::size_t i = 0; i < after.rgb.size(); ++i) {
      const bool is_hidden = after.mask[i % after.num_pixels()] == 0;
      hidden += is_hidden ? 1 : 0;
      changed += before.rgb[i] != after.rgb[i] ? 1 : 0;
      ASSERT_TRUE(is_hidden || before.rgb[i] == after.rgb[i]);
    }
    EXPECT_GT(changed, hidden / 2);
    EXPECT_LT(hidden, static_cast<int>(after.rgb.size()) / 2);
  }
}

// Between points and their pixels in all views, shifted to the right.
double MedianColorDifference(const Scene& scene, const gs::Scene& loaded, int shift) {
  std::vector<double> differences;
  for (Index n = 0; n < loaded.points.size(); ++n) {
    const auto& position = loaded.points.positions[static_cast<std::size_t>(n)];
    const Vec3 point{position[0], position[1], position[2]};
    for (const gs::View& view : loaded.views) {
      const auto eye = gs::CameraCenter(view);
      const Vec3 origin{eye[0], eye[1], eye[2]};
      const Vec3 projected = Project(view, point);
      const int i = static_cast<int>(std::floor(projected.x)) + shift, j = static_cast<int>(std::floor(projected.y));
      if (projected.z <= 0 || i < 0 || i >= view.camera.width || j < 0 || j >= view.camera.height) continue;
      const double distance = Length(point - origin);
      const Hit hit = Intersect(scene, origin, (1 / distance) * (point - origin));
      if (std::abs(hit.distance - distance) > 0.03 * distance) continue;  // occluded
      for (int c = 0; c < 3; ++c) {
        const float pixel = view.image.plane(c)[j * view.camera.width + i];
        differences.push_back(std::abs(pixel - loaded.points.colors[static_cast<std::size_t>(n)][c]));
      }
    }
  }
  if (differences.empty()) return 1;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return *middle;
}

TEST_F(DemoSceneTest, PointsHaveTheColorsOfThePixelsTheyProjectTo) {
  for (const char* lens : {"", "-0.2,0.04"}) {
    WriteDemoScene({.views = 4, .width = 120, .height = 90, .points = 400, .lens = ParseLens(lens)}, folder_.string());
    const Scene scene = MakeScene();
    const gs::Scene loaded = gs::LoadScene(folder_.string());
    const double in_place = MedianColorDifference(scene, loaded, 0);
    EXPECT_LT(in_place, 0.03) << lens;
    EXPECT_GT(MedianColorDifference(scene, loaded, 8), 3 * in_place) << lens;
  }
}

TEST_F(DemoSceneTest, PointNoiseIsTheStatedShareOfTheDistance) {
  const Scene scene = MakeScene();
  const std::vector<View> views = CameraPath(2, 40, 30);
  const std::vector<gs::Image> images(2, gs::Image(40, 30));
  // Noise moves floor points off the floor only along y, so one axis is sampled.
  double sum2 = 0;
  int count = 0;
  for (const SurfacePoint& p : SampleSurface(scene, views, images, 20000, 3)) {
    if (std::abs(p.position.y) > 0.1 || Length(p.position.x, p.position.z) < scene.rug_radius) continue;
    const double to_eye = std::min(Length(p.position - views[0].position), Length(p.position - views[1].position));
    if (to_eye < 3.5 || Length(p.position.x, p.position.z) > 4.5) continue;
    sum2 += p.position.y * p.position.y;
    ++count;
  }
  ASSERT_GT(count, 100);
  const double deviation = std::sqrt(sum2 / count);  // at distances from 3.5 to about 7
  EXPECT_GT(deviation, 3.5 * kPointNoise);
  EXPECT_LT(deviation, 7.5 * kPointNoise);
}

TEST_F(DemoSceneTest, SameBytesForAnyNumberOfThreads) {
  for (const int threads : {1, 2}) {
    SetNumThreads(threads);
    WriteDemoScene(kSmall, (folder_ / std::to_string(threads)).string());
  }
  SetNumThreads(0);
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "1")) {
    if (!entry.is_regular_file()) continue;
    const std::string bytes = ReadBytes(entry.path().string());
    EXPECT_FALSE(bytes.empty());
    EXPECT_EQ(bytes, ReadBytes((folder_ / "2" / entry.path().lexically_relative(folder_ / "1")).string()))
        << entry.path();
    ++files;
  }
  EXPECT_EQ(files, 10 + 3);
}

TEST_F(DemoSceneTest, BadOptionsAreRefused) {
  EXPECT_THROW(WriteDemoScene({.views = 1}, folder_.string()), Error);
  EXPECT_THROW(WriteDemoScene({.width = 0}, folder_.string()), Error);
  EXPECT_THROW(WriteDemoScene({.points = 0}, folder_.string()), Error);
  EXPECT_THROW(WriteDemoScene(kSmall, "/proc/nowhere"), Error);
  EXPECT_THROW(WriteDemoScene({.lens = ParseLens("-1")}, folder_.string()), Error);
  EXPECT_FALSE(std::filesystem::exists(folder_));
}

}  // namespace
}  // namespace vesta::demo
