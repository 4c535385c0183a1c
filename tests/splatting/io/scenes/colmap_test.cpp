// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/scenes/colmap.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "kernels/core/files.h"
#include "kernels/math/quaternion.h"
#include "splatting/io/scenes/colmap_files.h"
#include "tests/splatting/io/test_scene.h"

namespace vesta::gs {
namespace {

class ColmapFormats : public testing::TestWithParam<ColmapFormat> {};
INSTANTIATE_TEST_SUITE_P(All, ColmapFormats, testing::Values(ColmapFormat::kBinary, ColmapFormat::kText));

TEST_P(ColmapFormats, RoundTripIsExact) {
  const TempFolder folder;
  const ColmapModel model = ExampleModel();
  WriteColmapModel(model, folder / "sparse/0", GetParam());
  ExpectSameModel(ReadColmapModel(folder / "sparse/0"), model);
}

// Different values in all places.
TEST_P(ColmapFormats, RoundTripOfDistortedCamerasIsExact) {
  const TempFolder folder;
  ColmapModel model = ExampleModel();
  model.cameras.clear();
  for (const int number : {2, 3, 4, 5, 6, 8, 9}) {
    ColmapCamera camera = ExampleModel().cameras[1];
    camera.id = static_cast<std::uint32_t>(number);
    const CameraModelInfo* info = FindCameraModel(number);
    ASSERT_NE(info, nullptr);
    double next = 0.1;
    ReadParameters(
        *info, [&](const char*) { return next += 1.0 / 3; }, &camera);
    model.cameras.push_back(camera);
  }
  for (ColmapImage& image : model.images) image.camera_id = 6;
  WriteColmapModel(model, folder / "sparse/0", GetParam());
  ExpectSameModel(ReadColmapModel(folder / "sparse/0"), model);
}

// Orders as in COLMAP's documentation, "Camera Models".
TEST(Colmap, ReadsTheParametersOfEachCameraModel) {
  const TempFolder folder;
  WriteColmapModel(ExampleModel(), folder.path(), ColmapFormat::kText);
  const auto read = [&](const std::string& text) {
    WriteBytes(folder / "cameras.txt", "1 " + text + "\n4000000000 PINHOLE 60 40 1 2 3 4\n");
    return ReadColmapModel(folder.path()).cameras[0];
  };
  const ColmapCamera simple = read("SIMPLE_RADIAL 60 40 50 30 20 0.1");
  EXPECT_TRUE(simple.camera.lens.fx == 50 && simple.camera.lens.fy == 50 && simple.camera.lens.cx == 30 &&
              simple.camera.lens.cy == 20);
  EXPECT_EQ(simple.distortion, (Distortion{.radial = {0.1}}));
  EXPECT_EQ(read("RADIAL 60 40 50 30 20 0.1 0.2").distortion, (Distortion{.radial = {0.1, 0.2}}));
  const ColmapCamera opencv = read("OPENCV 60 40 50 51 30 20 0.1 0.2 0.3 0.4");
  EXPECT_TRUE(opencv.camera.lens.fy == 51 && opencv.camera.lens.cx == 30);
  EXPECT_EQ(opencv.distortion, (Distortion{.radial = {0.1, 0.2}, .tangential = {0.3, 0.4}}));
  EXPECT_EQ(read("FULL_OPENCV 60 40 50 51 30 20 0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8").distortion,
            (Distortion{.radial = {0.1, 0.2, 0.5, 0.6, 0.7, 0.8}, .tangential = {0.3, 0.4}}));
  EXPECT_EQ(read("OPENCV_FISHEYE 60 40 50 51 30 20 0.1 0.2 0.3 0.4").distortion,
            (Distortion{.is_fisheye = true, .radial = {0.1, 0.2, 0.3, 0.4}}));
  EXPECT_EQ(read("SIMPLE_RADIAL_FISHEYE 60 40 50 30 20 0.1").distortion,
            (Distortion{.is_fisheye = true, .radial = {0.1}}));
  EXPECT_EQ(read("RADIAL_FISHEYE 60 40 50 30 20 0.1 0.2").distortion,
            (Distortion{.is_fisheye = true, .radial = {0.1, 0.2}}));
}

TEST(Colmap, ReadsTheObservationsOfABinaryModelAway) {
  const TempFolder folder;
  ColmapModel model = ExampleModel();
  model.images.resize(1);
  model.points.resize(1);
  WriteColmapModel(model, folder.path(), ColmapFormat::kBinary);
  // Two 2D points of the image and one track element of the point replace zero counts.
  std::string images = ReadBytes(folder / "images.bin");
  images.replace(images.size() - 8, 8, std::string("\2\0\0\0\0\0\0\0", 8) + std::string(48, 'o'));
  WriteBytes(folder / "images.bin", images);
  std::string points = ReadBytes(folder / "points3D.bin");
  points.replace(points.size() - 8, 8, std::string("\1\0\0\0\0\0\0\0", 8) + std::string(8, 't'));
  WriteBytes(folder / "points3D.bin", points);
  ExpectSameModel(ReadColmapModel(folder.path()), model);
  EXPECT_EQ(ReadColmapModel(folder.path(), true).points[0].seen_by, std::vector<std::uint32_t>{0x74747474});
}

TEST(Colmap, TracksBelongToTheScene) {
  const TempFolder folder;
  WriteColmapModel(ExampleModel(), folder / "sparse/0", ColmapFormat::kText);
  Scene scene = ReadColmapScene(folder.path(), "images");
  EXPECT_TRUE(ReadTracks(folder.path(), scene).empty()) << "no tracks";
  std::string points = ReadBytes(folder / "sparse/0/points3D.txt");
  points.insert(points.find_last_not_of('\n') + 1, " 2 0 5 1");
  WriteBytes(folder / "sparse/0/points3D.txt", points);
  const PointTracks tracks = ReadTracks(folder.path(), scene);
  ASSERT_EQ(std::ssize(tracks), scene.points.size());
  EXPECT_EQ(tracks.back(), (std::vector<std::uint32_t>{2, 5}));
  scene.points.positions.pop_back();
  EXPECT_TRUE(ReadTracks(folder.path(), scene).empty()) << "other points";
  EXPECT_TRUE(ReadTracks(folder / "sparse", scene).empty()) << "no model";
}

// Text as COLMAP and editors write it: a byte order mark, comments, observations, tracks, \r.
TEST(Colmap, ReadsTextOfOtherHands) {
  const TempFolder folder;
  const std::string mark = "\xEF\xBB\xBF";
  WriteBytes(folder / "cameras.txt", mark + "# Camera list\r\n#\r\n\r\n1 SIMPLE_PINHOLE 60 40 50.5 30 20\r\n");
  WriteBytes(
      folder / "images.txt",
      mark +
          "# Image list\n2 1 0 0 0 0.5 0 -1 1 one.jpg\n1.5 2.5 7 8.5 9.5 -1\n5 1 0 0 0 0 0 0 1 name with space.png\n\n"
          "3 0 1 0 0 0 0 0 1 two.jpg");
  WriteBytes(folder / "points3D.txt", mark + "7 1 2 3 10 20 30 0.5 2 0 5 1\n");
  const ColmapModel model = ReadColmapModel(folder.path());
  EXPECT_TRUE(model.points[0].seen_by.empty());
  EXPECT_EQ(ReadColmapModel(folder.path(), true).points[0].seen_by, (std::vector<std::uint32_t>{2, 5}));
  ASSERT_EQ(model.images.size(), 3u);
  EXPECT_EQ(model.images[0].name, "one.jpg");
  EXPECT_EQ(model.images[0].translation, (std::array<double, 3>{0.5, 0, -1}));
  EXPECT_EQ(model.images[1].name, "name with space.png");
  EXPECT_EQ(model.images[2].rotation, (std::array<double, 4>{0, 1, 0, 0}));
  EXPECT_EQ(model.cameras[0].camera.lens.fy, 50.5);
  EXPECT_EQ(model.cameras[0].camera.lens.cy, 20);
  EXPECT_EQ(model.points[0].color, (std::array<std::uint8_t, 3>{10, 20, 30}));
}

TEST(Colmap, FewerImagesThanInTheHeaderGiveANote) {
  const TempFolder folder;
  const std::string model_folder = folder / "sparse/0";
  WriteColmapModel(ExampleModel(), model_folder, ColmapFormat::kText);
  const std::string images = ReadFile(model_folder + "/images.txt");
  for (const auto& [count, notes] : {std::pair{"3", 0u}, {"2", 0u}, {"4", 1u}, {"many", 0u}}) {
    WriteBytes(model_folder + "/images.txt",
               fmt::format("# Image list\n# Number of images: {}, mean observations per image: 0\n{}", count, images));
    const Scene scene = ReadColmapScene(folder.path(), "images");
    ASSERT_EQ(scene.notes.size(), notes) << count;
    if (notes > 0) {
      EXPECT_THAT(scene.notes[0], testing::HasSubstr("4"));
    }
  }
}

TEST(Colmap, SceneHasNormalisedPosesSortedByName) {
  const TempFolder folder;
  WriteColmapModel(ExampleModel(), folder / "sparse/0", ColmapFormat::kBinary);
  const Scene scene = ReadColmapScene(folder.path(), "images_2");
  ASSERT_EQ(scene.views.size(), 3u);
  EXPECT_EQ(scene.views[0].name, "a 1.jpg");
  EXPECT_EQ(scene.views[0].image_path, folder / "images_2/a 1.jpg");
  EXPECT_EQ(scene.views[0].camera.width, 30);
  EXPECT_TRUE(scene.views[0].is_test());
  EXPECT_FALSE(scene.views[1].is_test() || scene.views[2].is_test());
  for (const View& view : scene.views) {
    const auto& r = view.rotation;
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b) {
        const double dot = r[3 * a] * r[3 * b] + r[3 * a + 1] * r[3 * b + 1] + r[3 * a + 2] * r[3 * b + 2];
        EXPECT_NEAR(dot, a == b ? 1 : 0, 1e-14);
      }
    }
  }
  ASSERT_EQ(scene.points.size(), 4);
  EXPECT_EQ(scene.points.positions[3][1], -1.0f);
  EXPECT_EQ(scene.points.colors[3], (std::array<float, 3>{0, 3 / 255.0f, 1}));
}

// 90 degrees about z map x to y. World to camera, quaternion w x y z.
TEST(Colmap, QuaternionTurnsWorldIntoCamera) {
  const TempFolder folder;
  ColmapModel model = ExampleModel();
  model.images.resize(1);
  model.images[0].rotation = {2, 0, 0, 2};
  WriteColmapModel(model, folder / "sparse", ColmapFormat::kText);
  const Scene scene = ReadColmapScene(folder.path(), "images");
  const std::array<double, 9> expected{0, -1, 0, 1, 0, 0, 0, 0, 1};
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(scene.views[0].rotation[i], expected[i], 1e-15);
}

// In its own frame or another.
TEST(Colmap, OfASceneIsThatScene) {
  for (const double far : {0.0, 1000.0}) {
    Scene scene;
    scene.origin = {far, -2 * far, 0};
    for (int v = 0; v < 3; ++v) {
      View& view = scene.views.emplace_back();
      view.name = fmt::format("{}.png", v);
      view.camera = {.width = 40, .height = 30, .lens = {.fx = 50, .fy = v == 2 ? 51.0 : 50.0, .cx = 20, .cy = 15}};
      const double q[4] = {0.9, 0.1 * v, -0.2, 0.3};
      RotationFromQuaternion(q, view.rotation.data());
      view.translation = {0.1, 0.2 * v, 3};
    }
    scene.points.positions = {{1, 2, 3}, {-1, 0, 0.5}};
    scene.points.colors = {{0, 0.5, 1}, {1, 1, 1}};
    const ColmapModel model = ColmapOf(scene, scene.views);
    EXPECT_EQ(model.cameras.size(), 2U);
    ASSERT_EQ(model.images.size(), 3U);
    for (std::size_t v = 0; v < 3; ++v) {
      const ColmapImage& image = model.images[v];
      const View& view = scene.views[v];
      EXPECT_EQ(image.name, view.name);
      EXPECT_EQ(image.camera_id, v == 2 ? 2U : 1U);
      std::array<double, 9> R{};
      RotationFromQuaternion(image.rotation.data(), R.data());
      // A world point has the same camera coordinates.
      const std::array<double, 3> x{0.3, -0.2, 0.4};
      for (std::size_t i = 0; i < 3; ++i) {
        double there = image.translation[i], here = view.translation[i];
        for (std::size_t j = 0; j < 3; ++j) {
          there += R[3 * i + j] * (x[j] + scene.origin[j]);
          here += view.rotation[3 * i + j] * x[j];
        }
        EXPECT_NEAR(there, here, 1e-12 * (1 + far));
      }
    }
    EXPECT_EQ(model.points[0].position[1], 2 + scene.origin[1]);
    EXPECT_EQ(model.points[0].color[1], 128);
    // With the camera of the original files.
    const LensCamera opencv{{80, 60, {100, 101, 41, 29}}, {.radial = {-0.1, 0.02, 0.01}, .tangential = {0.001, 0}}},
        fisheye{{80, 60, {100, 101, 41, 29}}, {.is_fisheye = true, .radial = {0.1, 0.02}}};
    scene.views[0].bent = opencv, scene.views[1].bent = fisheye;
    const TempFolder folder;
    WriteColmapModel(ColmapOf(scene, scene.views), folder.path(), ColmapFormat::kText);
    const ColmapModel bent = ReadColmapModel(folder.path());
    ASSERT_EQ(bent.cameras.size(), 3U);
    for (const auto& [v, expected] : {std::pair(0U, opencv), std::pair(1U, fisheye)}) {
      const auto id = bent.images[v].camera_id;
      const auto camera = std::ranges::find(bent.cameras, id, &ColmapCamera::id);
      EXPECT_EQ((LensCamera{camera->camera, camera->distortion}), expected);
    }
  }
}

}  // namespace
}  // namespace vesta::gs
