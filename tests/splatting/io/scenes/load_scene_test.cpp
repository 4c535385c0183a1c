// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/scenes/load_scene.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "kernels/core/files.h"
#include "problems/gaussian_splatting/scene/undistort.h"
#include "splatting/io/images/image_file.h"
#include "splatting/io/scenes/colmap.h"
#include "splatting/io/scenes/nerf.h"
#include "tests/splatting/io/nine_views.h"
#include "tests/splatting/points/plane_views.h"

namespace vesta::gs {
namespace {

class LoadSceneTest : public NineViews {
 protected:
  LoadSceneTest() : NineViews("view", ".png") {}
  void ExpectRefused(ErrorCode code, const std::vector<std::string>& tokens, const LoadSceneOptions& options = {}) {
    EXPECT_THAT([&] { LoadScene(folder_.path(), options); }, ThrowsErrorWith(code, tokens));
  }
};

TEST_F(LoadSceneTest, LoadsAllPixels) {
  const Scene scene = LoadScene(folder_.path());
  ASSERT_EQ(scene.views.size(), 9u);
  const Image expected = LoadImage(ImagePath(0));
  for (const View& view : scene.views) {
    EXPECT_EQ(view.image.rgb, expected.rgb);
    EXPECT_EQ(view.camera.lens.fx, model_.cameras[0].camera.lens.fx);
  }
  EXPECT_TRUE(scene.views[0].is_test() && scene.views[8].is_test());
  EXPECT_EQ(scene.points.size(), 4);
}

// Photographs in nested folders, in all formats, with any file name extension.
TEST_F(LoadSceneTest, PhotographsOfEveryKindInNestedFolders) {
  const std::vector<std::uint8_t> bytes(60 * 40 * 3, 51);
  const std::string files[] = {EncodePng({60, 40, 2, 8, false, bytes}), EncodeWebp(60, 40, 3, bytes),
                               EncodeTiff({.width = 60, .height = 40, .bytes = bytes})};
  for (std::size_t i = 0; i < 3; ++i) {
    model_.images[i].name = fmt::format("day 1/left/{}.JPG", i);
    WriteBytes(folder_ / ("images/" + model_.images[i].name), files[i]);
  }
  WriteModel();
  const Scene scene = LoadScene(folder_.path());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(scene.views[i].name, model_.images[i].name);
    EXPECT_EQ(scene.views[i].image.rgb, std::vector<float>(60 * 40 * 3, 0.2f));
  }
}

TEST_F(LoadSceneTest, DownscalingTakesTheCameraAlong) {
  LoadSceneOptions options;
  options.downscale = 7;
  options.eps2d = 0.1;
  const Scene scene = LoadScene(folder_.path(), options);
  const View& view = scene.views[3];
  EXPECT_EQ(view.camera.eps2d, 0.1);  // in pixels of the loaded size
  for (const double eps2d : {0.0, -1.0, 5.0, std::nan("")}) {
    options.eps2d = eps2d;
    EXPECT_THROW(LoadScene(folder_.path(), options), Error);
  }
  EXPECT_EQ(view.image.width, 8);
  EXPECT_EQ(view.image.height, 5);
  EXPECT_EQ(view.camera.width, 8);
  EXPECT_DOUBLE_EQ(view.camera.lens.fx, model_.cameras[0].camera.lens.fx * 8 / 60);
  EXPECT_DOUBLE_EQ(view.camera.lens.cy, model_.cameras[0].camera.lens.cy * 5 / 40);
  EXPECT_EQ(view.image.rgb, ResizeArea(LoadImage(ImagePath(3)), 8, 5).rgb);
}

TEST_F(LoadSceneTest, SmallerCopiesOfTheImagesRescaleTheCamera) {
  for (std::uint32_t i = 0; i < 9; ++i)
    WriteBytes(folder_ / ("images_4/view" + std::to_string(i) + ".png"), ExampleJpeg(16, 10));
  LoadSceneOptions options;
  options.image_folder = "images_4";
  const Scene scene = LoadScene(folder_.path(), options);
  EXPECT_EQ(scene.views[1].camera.width, 16);
  EXPECT_DOUBLE_EQ(scene.views[1].camera.lens.fx, model_.cameras[0].camera.lens.fx * 16 / 60);
  WriteBytes(folder_ / "images_4/view5.png", ExampleJpeg(16, 12));
  ExpectRefused(kBadFile, {"images_4/view5.png", "16", "12", "60", "40"}, options);
}

// Each becomes a pinhole view. The image size may differ from the camera's, and undistortion precedes --downscale.
TEST_F(LoadSceneTest, DistortedPhotographsAreUndistorted) {
  ColmapCamera& camera = model_.cameras[0];
  camera.model = ColmapCameraModel::kOpenCv;
  camera.distortion = {.radial = {-0.2, 0.03}, .tangential = {0.001, 0.002}};
  WriteModel();
  WriteBytes(ImagePath(5), ExampleJpeg(30, 20));
  const Scene scene = LoadScene(folder_.path());
  const Camera pinhole = PinholeOf(camera.camera, camera.distortion).value();
  EXPECT_TRUE(pinhole.width != 60 || pinhole.height != 40);
  EXPECT_EQ(scene.views[1].camera.width, pinhole.width);
  EXPECT_EQ(scene.views[1].camera.lens.cx, pinhole.lens.cx);
  EXPECT_EQ(scene.views[1].camera.lens.fx, camera.camera.lens.fx);
  EXPECT_TRUE(scene.views[1].distortion.is_none());
  EXPECT_EQ(scene.views[1].image.rgb,
            UndistortImage(LoadImage(ImagePath(1)), camera.camera, camera.distortion, pinhole).rgb);
  EXPECT_EQ(scene.views[5].camera.lens.fx, camera.camera.lens.fx / 2);
  EXPECT_NEAR(scene.views[5].camera.width, pinhole.width / 2.0, 2);
  EXPECT_EQ(scene.views[5].image.width, scene.views[5].camera.width);
  EXPECT_THAT(scene.notes, testing::ElementsAre("9 of 9 photographs are undistorted on loading; training and metrics "
                                                "use the undistorted images"));
  LoadSceneOptions options;
  options.downscale = 2;
  const Scene half = LoadScene(folder_.path(), options);
  EXPECT_EQ(half.views[1].image.width, pinhole.width / 2);
  EXPECT_EQ(half.views[1].image.rgb, ResizeArea(scene.views[1].image, pinhole.width / 2, pinhole.height / 2).rgb);
}

TEST_F(LoadSceneTest, DistortionThatLeavesNothingIsRefused) {
  model_.cameras[0].model = ColmapCameraModel::kRadial;
  model_.cameras[0].distortion = {.radial = {-1000, 1}};
  WriteModel();
  ExpectRefused(kBadFile, {"view0.png"});
}

TEST_F(LoadSceneTest, AlphaOfANerfSceneIsCompositedOverTheBackground) {
  Image clear(60, 40);
  SavePng(ImagePath(2), clear);
  std::string rgba = EncodePng({60, 40, 6, 8, false, std::vector<std::uint8_t>(60 * 40 * 4, 0)});
  WriteBytes(ImagePath(3), rgba);
  LoadSceneOptions options;
  options.background = {1, 0.5f, 0.25f};
  std::filesystem::remove_all(folder_ / "sparse");
  std::string frames;
  for (int i = 0; i < 4; ++i) frames += fmt::format(R"({}{{"file_path": "images/view{}"}})", i > 0 ? "," : "", i);
  WriteBytes(folder_ / "transforms.json",
             R"({"camera_angle_x": 1.0, "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]], "frames": [)" +
                 frames + "]}");
  const Scene scene = LoadScene(folder_.path(), options);
  EXPECT_EQ(scene.views[2].image.plane(1)[7], 0);
  for (int c = 0; c < 3; ++c)
    EXPECT_EQ(scene.views[3].image.plane(c)[7], options.background[static_cast<std::size_t>(c)]);
  EXPECT_TRUE(scene.views[2].image.transparency.empty());
  EXPECT_EQ(scene.views[3].image.transparency, std::vector<float>(60 * 40, 1));
  EXPECT_TRUE(scene.views[3].image.mask.empty());
}

TEST_F(LoadSceneTest, RefusesScenesItCannotUse) {
  std::filesystem::remove(ImagePath(4));
  ExpectRefused(kNotFound, {"view4.png", folder_.path(), "1", "9"});
  WriteBytes(ImagePath(4), "no image");
  ExpectRefused(kBadFile, {"view4.png"});
  WriteBytes(ImagePath(4), ExampleJpeg(40, 60));
  ExpectRefused(kBadFile, {"view4.png", "40", "60"});
  model_.images[4].name = std::string(300, 'n');
  WriteModel();
  ExpectRefused(kNotFound, {folder_ / ("images/" + model_.images[4].name)});
  model_.images.resize(1);
  WriteModel();
  ExpectRefused(kBadArgument, {folder_.path()});
  std::filesystem::remove_all(folder_ / "sparse");
  const std::string images = folder_ / "images";
  ExpectRefused(kBadFile, {"sparse/0", "transforms.json", "reconstruct", images});
  EXPECT_THAT([&] { LoadScene(images); }, ThrowsError(kBadFile, "reconstruct", images, "--out=SCENE"));
  std::filesystem::create_directories(folder_ / "sparse");
  ExpectRefused(kNotFound, {folder_ / "sparse", "reconstruct", images});
  std::filesystem::create_directories(folder_ / "sparse/0");
  ExpectRefused(kNotFound, {folder_ / "sparse/0", "reconstruct", images});
  EXPECT_THAT([&] { LoadScene(folder_ / "nowhere"); }, ThrowsError(kNotFound, folder_ / "nowhere"));
  EXPECT_THAT([&] { LoadScene(ImagePath(0)); }, ThrowsError(kNotFound, ImagePath(0)));
}

TEST_F(LoadSceneTest, ImagesOutsideTheSceneAreRefused) {
  const std::string elsewhere = folder_.path() + "_elsewhere.jpg";
  WriteBytes(elsewhere, ExampleJpeg(60, 40));
  const std::string name = std::filesystem::path(elsewhere).filename().string();
  for (const std::string& outside : {"../../" + name, "a/../../../" + name, elsewhere}) {
    model_.images[4].name = outside;
    WriteModel();
    ExpectRefused(kBadFile, {"sparse/0", Printable(outside)});
  }
  model_.images[4].name = "../images/view4.png";
  WriteModel();
  EXPECT_EQ(LoadScene(folder_.path()).views.size(), 9u);
  std::filesystem::remove_all(folder_ / "sparse");
  for (const std::string& outside : {"../" + name, elsewhere}) {
    WriteBytes(folder_ / "transforms.json",
               R"({"camera_angle_x": 1.0, "frames": [{"file_path": ")" + outside + "\"}]}");
    ExpectRefused(kBadFile, {"0", Printable(outside)});
  }
  std::filesystem::remove(elsewhere);
}

TEST_F(LoadSceneTest, WhatIsPassedOverIsNoted) {
  EXPECT_THAT(LoadScene(folder_.path()).notes, testing::IsEmpty());
  std::filesystem::create_directory(folder_ / "sparse/empty");
  ColmapModel larger = model_;
  larger.images.resize(5);
  WriteColmapModel(larger, folder_ / "sparse/1", ColmapFormat::kBinary);
  WriteColmapModel(larger, folder_ / "sparse/2", ColmapFormat::kText);
  const std::string sparse = folder_ / "sparse/";
  EXPECT_THAT(
      LoadScene(folder_.path()).notes,
      testing::ElementsAre(
          "the model in " + sparse + "1 of 5 images is ignored; the model in " + sparse + "0 of 9 images is used",
          "the model in " + sparse + "2 is ignored; the model in " + sparse + "0 of 9 images is used"));
}

TEST_F(LoadSceneTest, MissingPhotographsMayBeLeftOut) {
  LoadSceneOptions options;
  options.allow_missing = true;
  EXPECT_EQ(LoadScene(folder_.path(), options).views.size(), 9u);
  for (const std::uint32_t i : {0u, 4u}) std::filesystem::remove(ImagePath(i));
  ExpectRefused(kNotFound, {"--allow_missing"});
  const Scene scene = LoadScene(folder_.path(), options);
  ASSERT_EQ(scene.views.size(), 7u);
  EXPECT_TRUE(!scene.views[0].is_test() && scene.views[6].is_test()) << "the choice of test views does not change";
  EXPECT_THAT(scene.notes, testing::ElementsAre("2 of 9 photographs that the model names are missing and left out"));
  std::filesystem::remove_all(folder_ / "images");
  ExpectRefused(kNotFound, {"view0.png", folder_.path(), "9"}, options);
}

TEST_F(LoadSceneTest, TestViewsAreThoseAskedFor) {
  const auto tests = [&](const TestViews& choice) {
    LoadSceneOptions options;
    options.test_views = choice;
    std::string names;
    for (const View& view : LoadScene(folder_.path(), options).views) {
      if (view.is_test()) names += view.name.substr(4, 1);
    }
    return names;
  };
  EXPECT_EQ(tests({}), "08");
  EXPECT_EQ(tests({.every = 3, .list = {}}), "036");
  EXPECT_EQ(tests({.every = 0, .list = {}}), "");
  WriteBytes(folder_ / "tests.txt", "# those of the paper\n\n view5.png \r\nview2.png");
  EXPECT_EQ(tests({.every = {}, .list = folder_ / "tests.txt"}), "25");
  LoadSceneOptions options;
  options.test_views.list = folder_ / "tests.txt";
  EXPECT_THAT(LoadScene(folder_.path(), options).files, testing::Contains(folder_ / "tests.txt"));
  WriteBytes(folder_ / "tests.txt", "view5.png\nview99.png\n");
  ExpectRefused(kNotFound, {"tests.txt", "2", "view99.png", "view0.png"}, options);
  options.test_views.every = 2;
  ExpectRefused(kBadArgument, {"--test_every", "--test_list"}, options);
  options.test_views = {.every = 1, .list = {}};
  ExpectRefused(kBadArgument, {folder_.path()}, options);
  options.test_views = {.every = {}, .list = folder_ / "none.txt"};
  ExpectRefused(kNotFound, {"none.txt"}, options);
}

TEST_F(LoadSceneTest, ImageFoldersLieWithinTheScene) {
  LoadSceneOptions options;
  options.image_folder = "images_8";
  ExpectRefused(kNotFound, {"images_8", "--images"}, options);
  for (const char* outside : {"../images", "/tmp", ""}) {
    options.image_folder = outside;
    ExpectRefused(kBadArgument, {std::string("--images=") + outside}, options);
  }
}

TEST_F(LoadSceneTest, SaysWhatChoseTheTestViews) {
  model_.images[2].name = "day/view2.png";
  WriteBytes(ImagePath(2), ExampleJpeg(60, 40));
  WriteModel();
  const auto split = [&](const TestViews& choice) {
    LoadSceneOptions options;
    options.test_views = choice;
    return LoadScene(folder_.path(), options).split;
  };
  EXPECT_EQ(split({}), Scene().split);
  EXPECT_EQ(split({.every = 4, .list = {}}), "--test_every=4");
  const std::string list = folder_ / "list.txt";
  WriteBytes(list, "view1.png\r\nday\\view2.png\n");
  EXPECT_EQ(split({.every = {}, .list = list}), "--test_list");
}

TEST_F(LoadSceneTest, ModelsWithoutPointsGetRandomOnesThatViewsSee) {
  model_ = ExampleModel();
  model_.points.clear();
  model_.images.resize(1);
  model_.images[0].translation = {0, 0, 0};
  for (std::uint32_t i = 1; i < 9; ++i) {
    model_.images.push_back(model_.images[0]);
    model_.images[i].id = i;
    model_.images[i].translation = {0.1 * i, 0, 0};
  }
  for (std::uint32_t i = 0; i < 9; ++i) model_.images[i].name = "view" + std::to_string(i) + ".png";
  WriteModel();
  LoadSceneOptions options;
  options.random_points.count = 500;
  const Scene scene = LoadScene(folder_.path(), options);
  ASSERT_EQ(scene.points.size(), 500);
  for (const auto& point : scene.points.positions) {
    EXPECT_TRUE(std::ranges::any_of(scene.views, [&](const View& view) { return DepthInView(view, point) > 0; }));
  }
  EXPECT_THAT(scene.notes, testing::ElementsAre("the model in " + folder_.path() +
                                                "/sparse/0 has no points: 500 random points are used instead, "
                                                "in the cameras' views"));
  EXPECT_EQ(LoadScene(folder_.path(), options).points.positions, scene.points.positions);
}

TEST_F(LoadSceneTest, PointsOnSurfacesTakeThePlaceOfRandomOnes) {
  const std::vector<View> views = test::TexturedViews({}, 5);
  model_ = ExampleModel();
  model_.points.clear();
  model_.images.resize(1);
  model_.cameras[0].camera = views[0].camera;
  model_.images[0].rotation = {1, 0, 0, 0};
  for (std::uint32_t i = 0; i < 5; ++i) {
    if (i > 0) model_.images.push_back(model_.images[0]);
    model_.images[i].id = i;
    model_.images[i].name = fmt::format("view{}.png", i);
    model_.images[i].translation = views[i].translation;
    SavePng(ImagePath(i), views[i].image);
  }
  WriteModel();
  LoadSceneOptions options;
  options.random_points.count = 100;
  options.test_views.every = 0;
  const Scene random = LoadScene(folder_.path(), options);
  options.finds_points = true;
  const Scene found = LoadScene(folder_.path(), options);
  ASSERT_EQ(found.points.size(), 100);
  const auto on_plane = [](const Scene& scene) {
    return std::ranges::count_if(scene.points.positions, [](const auto& p) { return std::abs(p[2] - 4) < 0.1f; });
  };
  EXPECT_LT(on_plane(random), 20);
  EXPECT_GT(on_plane(found), 90);
  EXPECT_NEAR(found.extent, 0.5 * 4, 0.05);
  EXPECT_NE(found.points_note, random.points_note);
  EXPECT_THAT(found.notes, testing::ElementsAre(found.points_note));
  // Photographs without texture leave the random points.
  for (std::uint32_t i = 0; i < 5; ++i) SavePng(ImagePath(i), Image(test::kPlaneWidth, test::kPlaneHeight));
  const Scene flat = LoadScene(folder_.path(), options);
  EXPECT_EQ(flat.points.positions, random.points.positions);
  EXPECT_EQ(flat.notes, random.notes);
}

// The cameras look at a common point, and some are in the cube of PointsInCube.
TEST_F(LoadSceneTest, RandomPointsAreTheSameInBothKindsOfScenes) {
  model_.points.clear();
  for (std::size_t i = 0; i < 9; ++i) {
    const double x = 0.5 * static_cast<double>(i) - 2, angle = std::atan2(x, 5.0);
    model_.images[i].rotation = {std::cos(angle / 2), 0, std::sin(angle / 2), 0};
    model_.images[i].translation = {-x * std::cos(angle), 0, x * std::sin(angle)};
  }
  WriteModel();
  LoadSceneOptions options;
  options.random_points = {.count = 200, .seed = 3};
  const Scene colmap = LoadScene(folder_.path(), options);
  std::vector<View> views = colmap.views;
  for (View& view : views) view.name = "images/" + view.name;
  std::filesystem::remove_all(folder_ / "sparse");
  WriteNerfCameras(folder_ / "transforms.json", views);
  const Scene nerf = LoadScene(folder_.path(), options);
  ASSERT_EQ(nerf.points.size(), 200);
  EXPECT_EQ(nerf.points.colors, colmap.points.colors);
  for (std::size_t i = 0; i < 200; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(nerf.points.positions[i][k], colmap.points.positions[i][k], 1e-5f);
    }
  }
}

// Names in a text model: a Windows path, another case, and another case with another extension.
TEST_F(LoadSceneTest, PhotographsOfOtherSpellingAreFound) {
  model_.images[1].name = "day\\view1.png";
  model_.images[2].name = "VIEW2.PNG";
  model_.images[3].name = "View3.jpg";
  WriteBytes(folder_ / "images/day/view1.png", ExampleJpeg(60, 40));
  std::filesystem::remove_all(folder_ / "sparse");
  WriteColmapModel(model_, folder_ / "sparse/0", ColmapFormat::kText);
  const Scene scene = LoadScene(folder_.path());
  std::map<std::string, std::string> files;
  for (const View& view : scene.views) files[view.name] = view.image_path;
  EXPECT_EQ(files["day/view1.png"], folder_ / "images/day/view1.png");
  EXPECT_EQ(files["VIEW2.PNG"], folder_ / "images/view2.png");
  EXPECT_EQ(files["View3.jpg"], folder_ / "images/view3.png");
  EXPECT_THAT(scene.notes, testing::ElementsAre(HasTokens("2", "view2.png", "VIEW2.PNG")));
}

// A photograph is rotated by its EXIF orientation if the camera has the rotated size, otherwise kept as stored.
TEST_F(LoadSceneTest, PhotographsAreTurnedWhereTheirCamerasAre) {
  WriteBytes(ImagePath(3), WithOrientation(ExampleJpeg(40, 60), 6));
  WriteBytes(ImagePath(4), WithOrientation(ExampleJpeg(60, 40), 6));
  const Scene scene = LoadScene(folder_.path());
  EXPECT_EQ(scene.views[3].image.rgb, RotatedUpright(LoadImage(ImagePath(3)), 6).rgb);
  EXPECT_EQ(scene.views[4].image.rgb, LoadImage(ImagePath(4)).rgb);
  WriteBytes(ImagePath(3), WithOrientation(ExampleJpeg(40, 60), 3));
  ExpectRefused(kBadFile, {"view3.png", "40", "60"});
}

TEST_F(LoadSceneTest, NamesTheFilesItReads) {
  EXPECT_THAT(LoadScene(folder_.path()).files,
              testing::UnorderedElementsAre(folder_ / "sparse/0/cameras.bin", folder_ / "sparse/0/images.bin",
                                            folder_ / "sparse/0/points3D.bin"));
}

}  // namespace
}  // namespace vesta::gs
