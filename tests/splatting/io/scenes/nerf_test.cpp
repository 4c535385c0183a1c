// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/scenes/nerf.h"

#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/splatting/io/test_images.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

using nlohmann::json;

json Identity() { return {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}; }

json ExampleTransforms() {
  json top = {{"fl_x", 50.0}, {"fl_y", 51.0}, {"cx", 19.5}, {"cy", 15.5}, {"w", 40}, {"h", 30}};
  for (const char* name : {"images/b.jpg", "./images/a", "images/c.JPG"}) {
    top["frames"].push_back({{"file_path", name}, {"transform_matrix", Identity()}});
  }
  return top;
}

class NerfTest : public testing::Test {
 protected:
  void Write(const json& top, const char* name = "transforms.json") { WriteBytes(folder_ / name, top.dump()); }
  Scene Read() const { return ReadNerfScene(folder_.path()); }
  template <class... Tokens>
  void ExpectRefused(const json& top, ErrorCode code, const Tokens&... tokens) {
    Write(top);
    EXPECT_THAT([&] { Read(); }, ThrowsError(code, tokens...));
  }
  TempFolder folder_;
};

TEST_F(NerfTest, ReadsIntrinsicsNamesAndRandomPoints) {
  json top = ExampleTransforms();
  top["frames"][2]["fl_x"] = 60.0;
  Write(top);
  const Scene scene = Read();
  ASSERT_EQ(scene.views.size(), 3u);
  EXPECT_EQ(scene.views[0].name, "images/a.png");
  EXPECT_EQ(scene.views[0].image_path, folder_ / "images/a.png");
  EXPECT_EQ(scene.views[1].name, "images/b.jpg");
  EXPECT_EQ(scene.views[2].name, "images/c.JPG");
  EXPECT_TRUE(scene.views[0].is_test() && !scene.views[1].is_test());
  const Camera& camera = scene.views[0].camera;
  EXPECT_TRUE(camera.width == 40 && camera.height == 30 && camera.lens.fx == 50 && camera.lens.fy == 51 &&
              camera.lens.cx == 19.5 && camera.lens.cy == 15.5);
  EXPECT_EQ(scene.views[2].camera.lens.fx, 60) << "values of a frame take precedence";
  EXPECT_EQ(scene.points.size(), 10000);
}

TEST_F(NerfTest, RandomPointsAreInTheCubeOnlyIfAllCamerasFaceIt) {
  json top = ExampleTransforms();
  const auto place = [&](std::size_t frame, int axis, double at) {
    top["frames"][frame]["transform_matrix"][static_cast<std::size_t>(axis)][3] = at;
    Write(top);
  };
  const auto largest = [](const Scene& scene) {
    float most = 0;
    for (const auto& p : scene.points.positions) {
      for (float v : p) most = std::max(most, std::abs(v));
    }
    return most;
  };
  // The cameras look along -z of the world.
  for (std::size_t frame = 0; frame < 3; ++frame) place(frame, 2, 4);
  const Scene facing = Read();
  ASSERT_EQ(facing.points.size(), 10000);
  EXPECT_LE(largest(facing), 1.3f);
  EXPECT_GT(largest(facing), 1.29f);
  ASSERT_EQ(facing.notes.size(), 1u);
  EXPECT_EQ(ReadNerfScene(folder_.path(), {.random_points = {10, 0}}).points.positions[9], facing.points.positions[9]);
  EXPECT_NE(ReadNerfScene(folder_.path(), {.random_points = {10, 1}}).points.positions[9], facing.points.positions[9]);
  // b.jpg is a training view: beside the cube, beyond it, inside it.
  for (const auto& [axis, at, back] : {std::tuple{0, 1.31, 0.}, {2, -4., 4.}, {2, 1.29, 4.}}) {
    place(0, axis, at);
    const Scene scene = Read();
    EXPECT_GT(largest(scene), 1.35f) << axis << " " << at;
    EXPECT_EQ(scene.notes.size(), 1u);
    for (const auto& p : scene.points.positions) {
      const bool seen = std::ranges::any_of(scene.views, [&](const View& view) { return DepthInView(view, p) > 0; });
      ASSERT_TRUE(seen);
    }
    place(0, axis, back);
  }
}

TEST_F(NerfTest, ReadsDistortion) {
  json top = ExampleTransforms();
  top["k1"] = 0.1;
  top["p2"] = -0.02;
  top["frames"][1]["k3"] = 0.3;
  top["camera_model"] = "OPENCV";
  Write(top);
  EXPECT_EQ(Read().views[1].distortion, (Distortion{.radial = {0.1}, .tangential = {0, -0.02}}));
  EXPECT_EQ(Read().views[0].distortion, (Distortion{.radial = {0.1, 0, 0.3}, .tangential = {0, -0.02}}));
  top["p2"] = 0;
  top["k4"] = 0.4;
  for (const char* fisheye : {"camera_model", "is_fisheye"}) {
    json changed = top;
    changed[fisheye] = std::string(fisheye) == "is_fisheye" ? json(true) : json("OPENCV_FISHEYE");
    Write(changed);
    EXPECT_EQ(Read().views[1].distortion, (Distortion{.is_fisheye = true, .radial = {0.1, 0, 0, 0.4}}));
  }
}

TEST_F(NerfTest, AnotherFolderStandsForImages) {
  json top = ExampleTransforms();
  Write(top);
  const Scene scene = ReadNerfScene(folder_.path(), {.image_folder = "images_4"});
  EXPECT_EQ(scene.views[1].name, "images/b.jpg");
  EXPECT_EQ(scene.views[1].image_path, folder_ / "images_4/b.jpg");
  top["frames"][0]["file_path"] = "photos/b.jpg";
  Write(top);
  EXPECT_THAT([&] { ReadNerfScene(folder_.path(), {.image_folder = "images_4"}); },
              ThrowsError(kBadFile, "0", "--images=images_4", "photos/b.jpg", "images/"));
}

TEST_F(NerfTest, NamesOfOtherSpellingAreFound) {
  json top = ExampleTransforms();
  top["frames"][0]["file_path"] = "images\\b.jpg";
  top["frames"][1]["file_path"] = "images/a.png";
  Write(top);
  for (const char* name : {"images/B.JPG", "images/a.jpeg", "images/a.txt", "images/c.jpg", "images/C.jpg"}) {
    WriteBytes(folder_ / name, "");
  }
  const Scene scene = Read();
  EXPECT_EQ(scene.views[0].image_path, folder_ / "images/a.jpeg");
  EXPECT_EQ(scene.views[1].name, "images/b.jpg");
  EXPECT_EQ(scene.views[1].image_path, folder_ / "images/B.JPG");
  EXPECT_EQ(scene.views[2].image_path, folder_ / "images/c.JPG") << "two files fit";
  top["frames"][0]["file_path"] = "..\\b.jpg";
  ExpectRefused(top, kBadFile, "0");
}

TEST_F(NerfTest, ImagesThatMayBeMissingNeedNoSize) {
  json top = ExampleTransforms();
  top.erase("w");
  Write(top);
  EXPECT_THAT([&] { Read(); }, ThrowsError(kNotFound, "images/b.jpg"));
  const Scene scene = ReadNerfScene(folder_.path(), {.allow_missing = true});
  EXPECT_EQ(scene.views[1].camera.width, 0);
  EXPECT_EQ(scene.points.size(), 10000);
}

// A camera at (1, 2, 3) that looks along -x with z up. In our axes: x right = +y, y down = -z, z forward = -x.
TEST_F(NerfTest, PosesAreTurnedIntoOurAxes) {
  json top = ExampleTransforms();
  top["frames"][0]["transform_matrix"] = {{0, 0, 1.0000001, 1}, {1, 0, 0, 2}, {0, 1, 0, 3}, {0, 0, 0, 1}};
  Write(top);
  const Scene scene = Read();
  const View& view = scene.views[1];
  const std::array<double, 9> expected{0, 1, 0, 0, 0, -1, -1, 0, 0};
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(view.rotation[i], expected[i], 1e-15);
  const auto center = CameraCenter(view);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(center[i], static_cast<double>(i + 1), 1e-15);
}

TEST_F(NerfTest, BlenderScenesHaveAnAngleAndTheirOwnSplit) {
  WriteBytes(folder_ / "train/r_0.png", ExampleJpeg(40, 30));
  WriteBytes(folder_ / "train/r_1.png", ExampleJpeg(40, 30));
  WriteBytes(folder_ / "test/r_0.png", ExampleJpeg(20, 30));
  json train = {{"camera_angle_x", 0.8}}, test = train;
  for (const char* name : {"./train/r_0", "./train/r_1"}) {
    train["frames"].push_back({{"file_path", name}, {"transform_matrix", Identity()}});
  }
  test["frames"].push_back({{"file_path", "./test/r_0"}, {"transform_matrix", Identity()}});
  Write(train, "transforms_train.json");
  Write(test, "transforms_test.json");
  EXPECT_TRUE(IsNerfScene(folder_.path()));
  const Scene scene = Read();
  ASSERT_EQ(scene.views.size(), 3u);
  EXPECT_EQ(scene.views[0].name, "test/r_0.png");
  EXPECT_TRUE(scene.views[0].is_test());
  EXPECT_FALSE(scene.views[1].is_test() || scene.views[2].is_test());
  EXPECT_EQ(scene.views[0].camera.width, 20) << "the size is read from the image";
  EXPECT_DOUBLE_EQ(scene.views[1].camera.lens.fx, 20 / std::tan(0.4));
  EXPECT_EQ(scene.views[1].camera.lens.fy, scene.views[1].camera.lens.fx);
  EXPECT_EQ(scene.views[1].camera.lens.cx, 20);
  EXPECT_EQ(scene.views[1].camera.lens.cy, 15);
  std::filesystem::remove(folder_ / "transforms_test.json");
  EXPECT_TRUE(Read().views[0].is_test()) << "without a test file, every 8th view";
}

std::string Roles(const Scene& scene) {
  std::string roles;
  for (const View& view : scene.views)
    roles += view.name.substr(7, 1) + (view.is_test() ? "t" : view.is_trained() ? "+" : "?");
  return roles;
}

TEST_F(NerfTest, FollowsTheListsOfFileNames) {
  struct Case {
    json lists;
    std::string roles, split;
  };
  const std::string test = "test_filenames", validation = "val_filenames", rule = Scene().split;
  const json a = {"images/a"}, b = {"./images/b.jpg"}, c = {"images/c.JPG"};
  for (const Case& each : std::vector<Case>{
           {{{"train_filenames", {"images/a.png", "images/c.JPG"}}, {"test_filenames", b}}, "a+btc+", test},
           {{{"train_filenames", a}, {"val_filenames", b}, {"test_filenames", c}}, "a+ct", test},
           {{{"train_filenames", a}, {"val_filenames", b}}, "a+bt", validation},
           {{{"train_filenames", b}}, "b+", "train_filenames"},
           {{{"test_filenames", c}}, "a+b+ct", test},
           {{{"val_filenames", b}, {"test_filenames", json::array()}}, "a+btc+", validation},
           {{{"test_filenames", {"images\\c.JPG"}}}, "a+b+ct", test},
           {{{"train_filenames", json::array()}}, "atb+c+", rule},
       }) {
    json top = ExampleTransforms();
    top.update(each.lists);
    SCOPED_TRACE(top);
    Write(top);
    const Scene scene = Read();
    EXPECT_EQ(Roles(scene), each.roles);
    EXPECT_EQ(scene.notes.size(), scene.views.size() < 3 ? 2u : 1u) << "a note on the points, and one on unused frames";
    EXPECT_EQ(scene.split, each.split);
    EXPECT_EQ(Roles(ReadNerfScene(folder_.path(), {.follow_split = false})), "atb+c+");
  }
  for (const auto& [lists, token] :
       std::vector<std::pair<json, std::string>>{{{{"train_filenames", {"images/d.jpg"}}}, "images/d.jpg"},
                                                 {{{"train_filenames", b}, {"test_filenames", b}}, "images/b.jpg"},
                                                 {{{"train_filenames", 7}}, "train_filenames"},
                                                 {{{"val_filenames", {7}}}, "val_filenames"}}) {
    json top = ExampleTransforms();
    top.update(lists);
    ExpectRefused(top, kBadFile, token);
  }
}

TEST_F(NerfTest, TestFramesAreTestViewsAndBadFramesAreLeftOut) {
  json top = ExampleTransforms();
  top["test_frames"] = {top["frames"][2]};
  top["frames"].erase(2);
  top["train_filenames"] = {"images/a"};
  Write(top);
  EXPECT_EQ(Roles(Read()), "a+b+ct");
  EXPECT_EQ(Read().split, "test_frames");
  top["frames"][0]["is_bad"] = true;
  top["frames"][1]["is_bad"] = false;
  Write(top);
  EXPECT_EQ(Roles(Read()), "a+ct");
  EXPECT_EQ(Read().notes.size(), 2u);
  top["test_frames"][0]["transform_matrix"] = 7;
  ExpectRefused(top, kBadFile, "test_frames", "0", "transform_matrix");
  top["test_frames"] = 7;
  ExpectRefused(top, kBadFile, "test_frames");
  top["test_frames"] = json::array(), top["frames"][1]["is_bad"] = 1;
  ExpectRefused(top, kBadFile, "1", "is_bad");
}

TEST_F(NerfTest, PointsComeFromAPlyWhereThereIsOne) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  Write(ExampleTransforms());
  WriteBytes(folder_ / "points3d.ply", header + "1 2 3 255 0 51\n4 5 6 0 0 0\n");
  EXPECT_EQ(Read().points.size(), 2);
  EXPECT_EQ(Read().points.colors[0], (std::array<float, 3>{1, 0, 0.2f}));
  json top = ExampleTransforms();
  top["ply_file_path"] = "mine.ply";
  Write(top);
  EXPECT_THAT([&] { Read(); }, ThrowsError(kNotFound, "mine.ply"));
  for (const char* outside : {"../mine.ply", "/mine.ply"}) {
    top["ply_file_path"] = outside;
    Write(top);
    EXPECT_THAT([&] { Read(); }, ThrowsError(kBadFile, outside));
  }
  top["ply_file_path"] = 7;
  Write(top);
  EXPECT_THAT([&] { Read(); }, ThrowsError(kBadFile, (folder_ / "transforms.json"), "ply_file_path"));
  top["ply_file_path"] = "mine.ply";
  Write(top);
  WriteBytes(folder_ / "mine.ply", header + "7 8 9 0 0 0\n4 5 6 0 0 0\n");
  EXPECT_EQ(Read().points.positions[0], (std::array<float, 3>{7, 8, 9}));
}

TEST_F(NerfTest, RefusesWhatItCannotUse) {
  struct Case {
    std::function<void(json&)> spoil;
    std::string token, second = "transforms.json";
    ErrorCode code = kBadFile;
  };
  for (const Case& each : std::vector<Case>{
           {[](json& top) { top["k4"] = 0.1; }, "k4", "0", kUnsupported},
           {[](json& top) { top["frames"][1]["p2"] = -0.1, top["is_fisheye"] = true; }, "p2", "1"},
           {[](json& top) { top["camera_model"] = "EQUIRECTANGULAR"; }, "EQUIRECTANGULAR", "", kUnsupported},
           {[](json& top) { top["is_fisheye"] = 1; }, "is_fisheye"},
           {[](json& top) { top["fl_x"] = 0; }, "51", "0"},
           {[](json& top) { top.erase("fl_x"), top.erase("fl_y"); }, "fl_x", "camera_angle_x"},
           {[](json& top) { top.erase("fl_x"), top.erase("fl_y"), top["camera_angle_x"] = 0.0; }, ""},
           {[](json& top) { top["fl_x"] = "fifty"; }, "fl_x"},
           {[](json& top) { top["w"] = 0; }, "30", "0"},
           {[](json& top) { top.erase("w"); }, "images/b.jpg", "", kNotFound},
           {[](json& top) { top["frames"][1].erase("file_path"); }, "file_path", "1"},
           {[](json& top) { top["frames"][1]["file_path"] = "images/b.jpg"; }, "images/b.jpg", ""},
           {[](json& top) { top["frames"][1] = 7; }, "1"},
           {[](json& top) { top["frames"] = json::array(); }, ""},
           {[](json& top) { top = json::array(); }, ""},
           {[](json& top) { top = "text"; }, ""},
           {[](json& top) { top["frames"][2].erase("transform_matrix"); }, "transform_matrix", "2"},
       }) {
    json top = ExampleTransforms();
    each.spoil(top);
    SCOPED_TRACE(top);
    ExpectRefused(top, each.code, each.token, each.second);
  }
  WriteBytes(folder_ / "transforms.json", ExampleTransforms().dump().substr(0, 100));
  EXPECT_THAT([&] { Read(); }, ThrowsError(kBadFile, "transforms.json"));
}

TEST_F(NerfTest, RefusesPosesThatAreNone) {
  json row = Identity(), number = Identity(), scaled = Identity(), mirrored = Identity(), flat = Identity();
  row[1] = {0, 1, 0};
  number[0][3] = nullptr;
  scaled[0][0] = 2, mirrored[0][0] = -1, flat[0][0] = 0;
  for (const json& pose : {row, json{1, 2, 3}, number, scaled, mirrored, flat}) {
    json bad = ExampleTransforms();
    bad["frames"][2]["transform_matrix"] = pose;
    ExpectRefused(bad, kBadFile, "2", "transform_matrix");
  }
}

TEST_F(NerfTest, OverwrittenBytesLoadOrAreRefused) {
  const auto read = [&](const std::string& damaged) {
    WriteBytes(folder_ / "transforms.json", damaged);
    ReadNerfScene(folder_.path(), {.random_points = {10, 0}});
  };
  EXPECT_GT(CountRefusedCopies(ExampleTransforms().dump(), 250, read), 0);
}

const Camera kUsual{40, 30, {50, 51, 19.5, 15.5}};

// The file that nerfstudio's viewer writes.
TEST_F(NerfTest, CameraPathsOfNerfstudioAreRead) {
  json top = {{"camera_type", "perspective"}, {"seconds", 4.0}};
  const json pose = {0, 0, 1, 1, 1, 0, 0, 2, 0, 1, 0, 3, 0, 0, 0, 1};
  top["camera_path"] = {{{"camera_to_world", pose}, {"fov", 90.0}, {"aspect", 1.5}}, {{"camera_to_world", pose}}};
  Write(top, "path.json");
  const std::vector<View> views = ReadNerfCameras(folder_ / "path.json", kUsual);
  ASSERT_EQ(views.size(), 2u);
  EXPECT_EQ(CameraCenter(views[0]), (std::array<double, 3>{1, 2, 3}));
  EXPECT_EQ(views[0].rotation, (std::array<double, 9>{0, 1, 0, 0, 0, -1, -1, 0, 0}));
  EXPECT_NEAR(views[0].camera.lens.fx, 15, 1e-12);
  EXPECT_NEAR(views[0].camera.lens.fy, 15, 1e-12);
  EXPECT_EQ(views[1].camera, kUsual);
  top["render_width"] = 2 * kUsual.width, top["render_height"] = 2 * kUsual.height;
  Write(top, "path.json");
  const std::vector<View> large = ReadNerfCameras(folder_ / "path.json", kUsual);
  EXPECT_NEAR(large[0].camera.lens.fy, 30, 1e-12);
  EXPECT_EQ(large[1].camera, CropCamera(kUsual, {2 * kUsual.width, 2 * kUsual.height}));
  for (const auto& [key, value] : std::map<std::string, json>{{"camera_to_world", {1, 2, 3}}, {"fov", 180}}) {
    json bad = top;
    bad["camera_path"][1][key] = value;
    Write(bad, "path.json");
    EXPECT_THAT([&] { ReadNerfCameras(folder_ / "path.json", kUsual); }, ThrowsError(kBadFile, "1", key));
  }
}

TEST_F(NerfTest, CamerasAreReadInTheirOrderWithoutImages) {
  json top;
  for (int i = 0; i < 3; ++i) {
    json matrix = Identity();
    matrix[0][3] = 3 - i;
    top["frames"].push_back({{"transform_matrix", matrix}});
  }
  top["frames"][1]["camera_angle_x"] = 1.0;
  top["frames"][2].update({{"w", 60}, {"h", 20}, {"fl_x", 70}});
  Write(top);
  const std::vector<View> views = ReadNerfCameras(folder_ / "transforms.json", kUsual);
  ASSERT_EQ(views.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(CameraCenter(views[i])[0], 3 - static_cast<double>(i), 1e-12);
  EXPECT_EQ(views[0].camera.lens.cx, 19.5) << "the given default camera";
  EXPECT_NEAR(views[1].camera.lens.fx, 20 / std::tan(0.5), 1e-9) << "with the default width";
  EXPECT_EQ(views[1].camera.lens.cx, 20);
  EXPECT_TRUE(views[2].camera.width == 60 && views[2].camera.height == 20 && views[2].camera.lens.fy == 70);
}

TEST_F(NerfTest, WrittenCamerasAreReadAgain) {
  Scene scene;
  for (int i = 0; i < 2; ++i) {
    View& view = scene.views.emplace_back();
    const double angle = 0.3 + i;
    view.name = "0" + std::to_string(i) + ".png";
    view.camera = {64, 48, {70.1, 71, 30.3, 25}};
    view.rotation = {std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0, std::cos(angle)};
    view.translation = {0.1, -2, 1.0 / 3};
  }
  const std::string file = folder_ / "cameras.json";
  WriteNerfCameras(file, scene.views, {{"depth_unit", 0.25}});
  EXPECT_EQ(json::parse(ReadBytes(file))["depth_unit"], 0.25);
  EXPECT_EQ(json::parse(ReadBytes(file))["frames"][1]["file_path"], "01.png");
  const std::vector<View> read = ReadNerfCameras(file, kUsual);
  ASSERT_EQ(read.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t k = 0; k < 9; ++k) EXPECT_NEAR(read[i].rotation[k], scene.views[i].rotation[k], 1e-15);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(read[i].translation[k], scene.views[i].translation[k], 1e-14);
    EXPECT_EQ(read[i].camera.lens.fx, 70.1);
    EXPECT_EQ(read[i].camera.lens.cy, 25);
  }
}

TEST_F(NerfTest, CamerasThatAreNoneAreRefused) {
  const std::string file = folder_ / "cameras.json";
  for (const auto& [text, token] : std::vector<std::pair<std::string, std::string>>{
           {"{}", ""},
           {R"({"frames": [)", ""},
           {R"({"frames": [{"file_path": "a"}]})", "transform_matrix"},
           {R"({"frames": [{"transform_matrix": )" + Identity().dump() + R"(, "w": 1e9, "h": 3}]})", "1000000000"},
           {R"({"frames": [{"transform_matrix": )" + Identity().dump() + R"(, "fl_x": 0}]})", "0"}}) {
    WriteBytes(file, text);
    EXPECT_THAT([&] { ReadNerfCameras(file, kUsual); }, ThrowsError(kBadFile, file, token));
  }
}

}  // namespace
}  // namespace vesta::gs
