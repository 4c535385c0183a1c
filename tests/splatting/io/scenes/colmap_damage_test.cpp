// SPDX-License-Identifier: Apache-2.0
// Damaged COLMAP models give a one-line error, without a crash.
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <limits>

#include "splatting/io/scenes/colmap.h"
#include "tests/splatting/io/test_scene.h"

namespace vesta::gs {
namespace {

const char* const kFiles[] = {"cameras", "images", "points3D"};

TEST(ColmapDamage, EveryPrefixOfEveryBinaryFileIsRefused) {
  const TempFolder folder;
  WriteColmapModel(ExampleModel(), folder.path(), ColmapFormat::kBinary);
  const auto read = [&] { ReadColmapModel(folder.path()); };
  for (const char* name : kFiles) {
    const std::string path = folder / (std::string(name) + ".bin");
    const std::string bytes = ReadBytes(path);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      WriteBytes(path, bytes.substr(0, length));
      EXPECT_THAT(read, ThrowsError(kBadFile, path)) << "cut to " << length;
    }
    WriteBytes(path, bytes + "x");
    EXPECT_THAT(read, ThrowsError(kBadFile, path, "1"));
    WriteBytes(path, bytes);
  }
  ExpectSameModel(ReadColmapModel(folder.path()), ExampleModel());
}

// Text has no counts: a file that ends after a complete record is a smaller model. Any other cut is refused.
TEST(ColmapDamage, NoPrefixOfATextFileCrashes) {
  const TempFolder folder;
  WriteColmapModel(ExampleModel(), folder.path(), ColmapFormat::kText);
  for (const char* name : kFiles) {
    const std::string path = folder / (std::string(name) + ".txt");
    const std::string bytes = ReadBytes(path);
    int refused = 0;
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      WriteBytes(path, bytes.substr(0, length));
      refused += ErrorOf([&] { ReadColmapModel(folder.path()); }) ? 1 : 0;
    }
    EXPECT_GT(refused, 40) << name;
    WriteBytes(path, bytes);
  }
}

class ColmapDamageFormats : public testing::TestWithParam<ColmapFormat> {};
INSTANTIATE_TEST_SUITE_P(All, ColmapDamageFormats, testing::Values(ColmapFormat::kBinary, ColmapFormat::kText));

TEST_P(ColmapDamageFormats, OverwrittenBytesLoadOrAreRefused) {
  const TempFolder folder;
  WriteColmapModel(ExampleModel(), folder.path(), GetParam());
  const std::string extension = GetParam() == ColmapFormat::kBinary ? ".bin" : ".txt";
  for (const char* name : kFiles) {
    const std::string path = folder / (name + extension);
    const std::string bytes = ReadBytes(path);
    const auto read = [&](const std::string& damaged) {
      WriteBytes(path, damaged);
      ReadColmapModel(folder.path());
    };
    EXPECT_GT(CountRefusedCopies(bytes, 120, read), 0) << name;
    WriteBytes(path, bytes);
  }
}

TEST_P(ColmapDamageFormats, PointsThatAreNotFiniteAreLeftOut) {
  const TempFolder folder;
  ColmapModel model = ExampleModel();
  const std::size_t all = model.points.size();
  model.points[1].position[0] = 1e39;
  WriteColmapModel(model, folder / "sparse/0", GetParam());
  EXPECT_EQ(ReadColmapModel(folder / "sparse/0").points.size(), all - 1);
  EXPECT_EQ(ReadColmapModel(folder / "sparse/0").unusable_points, 1);
  const Scene scene = ReadColmapScene(folder.path(), "images");
  EXPECT_EQ(scene.points.size(), static_cast<Index>(all) - 1);
  EXPECT_THAT(scene.notes, testing::Contains(HasTokens("1", std::to_string(all))));
  for (ColmapPoint& point : model.points) point.position[0] = std::nan("");
  WriteColmapModel(model, folder / "sparse/0", GetParam());
  EXPECT_THAT([&] { ReadColmapScene(folder.path(), "images"); }, ThrowsError(kBadFile, std::to_string(all)));
}

TEST_P(ColmapDamageFormats, UnusableValuesAreNamed) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  struct Case {
    std::function<void(ColmapModel*)> damage;
    std::vector<std::string> tokens;
  };
  const Case cases[] = {
      {[](ColmapModel* m) { m->cameras[0].camera.lens.fx = 0; }, {"1", "0"}},
      {[](ColmapModel* m) { m->cameras[0].camera.lens.fy = -5; }, {"1", "-5"}},
      {[&](ColmapModel* m) { m->cameras[1].camera.lens.fx = nan; }, {"4000000000", "nan"}},
      {[&](ColmapModel* m) { m->cameras[0].camera.lens.fx = infinity; }, {"1", "inf"}},
      {[&](ColmapModel* m) { m->cameras[0].camera.lens.cx = nan; }, {"1", "nan"}},
      {[&](ColmapModel* m) {
         m->cameras[0].model = ColmapCameraModel::kOpenCv;
         m->cameras[0].distortion.tangential[1] = nan;
       },
       {"1"}},
      {[](ColmapModel* m) { m->cameras[0].camera.width = 0; }, {"1", "0", "40"}},
      {[](ColmapModel* m) { m->cameras[0].camera.height = 0; }, {"1", "60", "0"}},
      {[](ColmapModel* m) { m->images[1].camera_id = 7; }, {"1.jpg", "7"}},
      {[&](ColmapModel* m) { m->images[0].rotation[2] = nan; }, {"b.jpg"}},
      {[&](ColmapModel* m) { m->images[0].translation[2] = infinity; }, {"b.jpg"}},
      {[](ColmapModel* m) { m->images[2].rotation = {}; }, {"folder/c.jpg"}},
      {[](ColmapModel* m) { m->images[2].name = "b.jpg"; }, {"b.jpg"}},
      {[](ColmapModel* m) { m->images[2].name = "b\x01.jpg"; }, {"8"}},
      {[](ColmapModel* m) { m->images[2].name = std::string(5000, 'n'); }, {"8"}},
      {[](ColmapModel* m) { m->images[0].name = ""; }, {"10"}},
      {[](ColmapModel* m) { m->cameras[1].id = 1; }, {"1"}},
      {[](ColmapModel* m) { m->images.clear(); }, {}},
      {[](ColmapModel* m) { m->cameras.clear(); }, {}},
  };
  for (const Case& c : cases) {
    const TempFolder folder;
    ColmapModel model = ExampleModel();
    c.damage(&model);
    WriteColmapModel(model, folder.path(), GetParam());
    EXPECT_THAT([&] { ReadColmapModel(folder.path()); }, ThrowsErrorWith(kBadFile, c.tokens));
  }
}

TEST_P(ColmapDamageFormats, MissingFilesAreNamed) {
  const std::string extension = GetParam() == ColmapFormat::kBinary ? ".bin" : ".txt";
  for (const char* name : {"images", "points3D"}) {
    const TempFolder folder;
    WriteColmapModel(ExampleModel(), folder.path(), GetParam());
    std::filesystem::remove(folder / (name + extension));
    EXPECT_THAT([&] { ReadColmapModel(folder.path()); }, ThrowsError(kNotFound, name + extension));
  }
}

TEST(ColmapDamage, CameraModelsThatAreNotReadAreRefusedWithTheCommandThatUndistorts) {
  const TempFolder folder;
  const std::string model_folder = folder / "sparse/0";
  WriteColmapModel(ExampleModel(), model_folder, ColmapFormat::kBinary);
  std::string bytes = ReadBytes(model_folder + "/cameras.bin");
  const auto read = [&] { ReadColmapModel(model_folder); };
  const auto refused = [&](const char* file, const char* camera) {
    return ThrowsError(kUnsupported, file, camera, "image_undistorter", folder.path() + "/images", model_folder);
  };
  for (const auto& [model, name] : {std::pair<char, const char*>{7, "FOV"}, {10, "THIN_PRISM_FISHEYE"}, {99, "99"}}) {
    bytes[12] = model;
    WriteBytes(model_folder + "/cameras.bin", bytes);
    EXPECT_THAT(read, refused("cameras.bin", name));
  }
  std::filesystem::remove_all(model_folder);
  WriteColmapModel(ExampleModel(), model_folder, ColmapFormat::kText);
  WriteBytes(model_folder + "/cameras.txt", "1 FOV 60 40 50 50 30 20 0.1\n");
  EXPECT_THAT(read, refused("cameras.txt", "FOV"));
}

TEST(ColmapDamage, TextErrorsNameTheLine) {
  const TempFolder folder;
  WriteColmapModel(ExampleModel(), folder.path(), ColmapFormat::kText);
  for (const auto& [text, line] : {std::pair<const char*, const char*>{"# a comment\n\n1 PINHOLE 60 40 50\n", "3"},
                                   {"1 SIMPLE_RADIAL 60 40 50 30 20\n", "1"},
                                   {"1 PINHOLE 60 40 50 fifty 30 20\n", "1"},
                                   {"-1 PINHOLE 60 40 50 50 30 20\n", "1"},
                                   {"1 PINHOLE 60000000000 40 50 50 30 20\n", "1"}}) {
    WriteBytes(folder / "cameras.txt", text);
    EXPECT_THAT([&] { ReadColmapModel(folder.path()); }, ThrowsError(kBadFile, folder / "cameras.txt", line)) << text;
  }
}

// Without the second lines, half of the images would be read as the 2D points of the others.
TEST(ColmapDamage, EachImageOfATextModelNeedsItsSecondLine) {
  const TempFolder folder;
  WriteColmapModel(ExampleModel(), folder.path(), ColmapFormat::kText);
  const std::string one = "1 1 0 0 0 0 0 0 7 one.jpg\n", two = "2 1 0 0 0 0 0 0 7 two two two.jpg\n";
  for (const auto& [text, line] :
       std::vector<std::pair<std::string, const char*>>{{fmt::format("{}{}", one, two), "2"},
                                                        {fmt::format("# two\n{}{}", two, one), "3"},
                                                        {fmt::format("{}1.5 2.5 -1 3.5\n{}\n", one, two), "2"},
                                                        {fmt::format("{}\n{}1 2 three\n", one, two), "4"}}) {
    WriteBytes(folder / "images.txt", text);
    EXPECT_THAT([&] { ReadColmapModel(folder.path()); }, ThrowsError(kBadFile, folder / "images.txt", line)) << text;
  }
}

}  // namespace
}  // namespace vesta::gs
