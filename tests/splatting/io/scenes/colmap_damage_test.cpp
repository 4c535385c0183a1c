// SPDX-License-Identifier: Apache-2.0
// COLMAP models that cannot be used: each gives one line, none crashes.
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
  for (const char* name : kFiles) {
    const std::string path = folder / (std::string(name) + ".bin");
    const std::string bytes = ReadBytes(path);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      WriteBytes(path, bytes.substr(0, length));
      const std::string message = ErrorOf([&] { ReadColmapModel(folder.path()); });
      EXPECT_THAT(message, testing::HasSubstr(path + ": byte ")) << "cut to " << length;
      EXPECT_THAT(message, testing::HasSubstr("copy or export it again")) << "cut to " << length;
    }
    WriteBytes(path, bytes + "x");
    ExpectError([&] { ReadColmapModel(folder.path()); }, "1 bytes follow the last record");
    WriteBytes(path, bytes);
  }
  ExpectSameModel(ReadColmapModel(folder.path()), ExampleModel());
}

// Text has no counts, so a cut at the end of a record is a smaller model; everything else must be refused.
TEST(ColmapDamage, NoPrefixOfATextFileCrashes) {
  const TempFolder folder;
  WriteColmapModel(ExampleModel(), folder.path(), ColmapFormat::kText);
  for (const char* name : kFiles) {
    const std::string path = folder / (std::string(name) + ".txt");
    const std::string bytes = ReadBytes(path);
    int refused = 0;
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      WriteBytes(path, bytes.substr(0, length));
      refused += ErrorOf([&] { ReadColmapModel(folder.path()); }).empty() ? 0 : 1;
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
    int refused = 0;
    ForDamagedCopies(bytes, 120, [&](const std::string& damaged) {
      WriteBytes(path, damaged);
      refused += ErrorOf([&] { ReadColmapModel(folder.path()); }).empty() ? 0 : 1;
    });
    EXPECT_GT(refused, 0) << name;
    WriteBytes(path, bytes);
  }
}

TEST_P(ColmapDamageFormats, UnusableValuesAreNamed) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  struct Case {
    std::function<void(ColmapModel*)> damage;
    const char* message;
  };
  const Case cases[] = {
      {[](ColmapModel* m) { m->cameras[0].camera.lens.fx = 0; }, "camera 1 has the focal lengths 0, "},
      {[](ColmapModel* m) { m->cameras[0].camera.lens.fy = -5; }, "they must be positive"},
      {[&](ColmapModel* m) { m->cameras[1].camera.lens.fx = nan; }, "camera 4000000000 has the focal lengths nan"},
      {[&](ColmapModel* m) { m->cameras[0].camera.lens.fx = infinity; }, "focal lengths inf"},
      {[&](ColmapModel* m) { m->cameras[0].camera.lens.cx = nan; }, "principal point nan"},
      {[&](ColmapModel* m) {
         m->cameras[0].model = ColmapCameraModel::kOpenCv;
         m->cameras[0].distortion.tangential[1] = nan;
       },
       "camera 1 has a distortion that is not finite"},
      {[](ColmapModel* m) { m->cameras[0].camera.width = 0; }, "camera 1 has the size 0 x 40"},
      {[](ColmapModel* m) { m->cameras[0].camera.height = 0; }, "camera 1 has the size 60 x 0"},
      {[](ColmapModel* m) { m->images[1].camera_id = 7; }, "image a 1.jpg refers to camera 7"},
      {[&](ColmapModel* m) { m->images[0].rotation[2] = nan; }, "the pose of image b.jpg is not finite"},
      {[&](ColmapModel* m) { m->images[0].translation[2] = infinity; }, "the pose of image b.jpg is not finite"},
      {[](ColmapModel* m) { m->images[2].rotation = {}; }, "the rotation of image folder/c.jpg is not a quaternion"},
      {[](ColmapModel* m) { m->images[2].name = "b.jpg"; }, "image b.jpg occurs twice"},
      {[](ColmapModel* m) { m->images[2].name = "b\x01.jpg"; }, "image 8 has no readable name"},
      {[](ColmapModel* m) { m->images[2].name = std::string(5000, 'n'); }, "image 8 has no readable name"},
      {[](ColmapModel* m) { m->images[0].name = ""; }, "image 10 has no readable name"},
      {[](ColmapModel* m) { m->cameras[1].id = 1; }, "camera 1 occurs twice"},
      {[&](ColmapModel* m) { m->points[1].position[0] = nan; }, "point 1099511627776 is not finite"},
      {[](ColmapModel* m) { m->points[1].position[0] = 1e39; }, "is not finite"},
      {[](ColmapModel* m) { m->images.clear(); }, "no images"},
      {[](ColmapModel* m) { m->cameras.clear(); }, "no cameras"},
  };
  for (const Case& c : cases) {
    const TempFolder folder;
    ColmapModel model = ExampleModel();
    c.damage(&model);
    WriteColmapModel(model, folder.path(), GetParam());
    ExpectError([&] { ReadColmapModel(folder.path()); }, c.message);
  }
}

TEST_P(ColmapDamageFormats, MissingFilesAreNamed) {
  const std::string extension = GetParam() == ColmapFormat::kBinary ? ".bin" : ".txt";
  for (const char* name : {"images", "points3D"}) {
    const TempFolder folder;
    WriteColmapModel(ExampleModel(), folder.path(), GetParam());
    std::filesystem::remove(folder / (name + extension));
    ExpectError([&] { ReadColmapModel(folder.path()); }, name + extension + ": no such file");
  }
}

TEST(ColmapDamage, CameraModelsThatAreNotReadAreRefusedWithTheCommandThatUndistorts) {
  const TempFolder folder;
  const std::string model_folder = folder / "sparse/0";
  WriteColmapModel(ExampleModel(), model_folder, ColmapFormat::kBinary);
  std::string bytes = ReadBytes(model_folder + "/cameras.bin");
  bytes[12] = 7;
  WriteBytes(model_folder + "/cameras.bin", bytes);
  const std::string command = "colmap image_undistorter --image_path " + folder.path() + "/images --input_path " +
                              model_folder + " --output_path ";
  ExpectError([&] { ReadColmapModel(model_folder); }, "cameras.bin: byte 12: the camera model FOV is not read");
  ExpectError([&] { ReadColmapModel(model_folder); }, command);
  bytes[12] = 10;
  WriteBytes(model_folder + "/cameras.bin", bytes);
  ExpectError([&] { ReadColmapModel(model_folder); }, "the camera model THIN_PRISM_FISHEYE is not read");
  bytes[12] = 99;
  WriteBytes(model_folder + "/cameras.bin", bytes);
  ExpectError([&] { ReadColmapModel(model_folder); }, "the camera model 99");

  std::filesystem::remove_all(model_folder);
  WriteColmapModel(ExampleModel(), model_folder, ColmapFormat::kText);
  WriteBytes(model_folder + "/cameras.txt", "1 FOV 60 40 50 50 30 20 0.1\n");
  ExpectError([&] { ReadColmapModel(model_folder); }, "cameras.txt: line 1: the camera model FOV");
  ExpectError([&] { ReadColmapModel(model_folder); }, command);
}

TEST(ColmapDamage, TextErrorsNameTheLine) {
  const TempFolder folder;
  WriteColmapModel(ExampleModel(), folder.path(), ColmapFormat::kText);
  const auto read = [&] { ReadColmapModel(folder.path()); };
  WriteBytes(folder / "cameras.txt", "# a comment\n\n1 PINHOLE 60 40 50\n");
  ExpectError(read, "cameras.txt: line 3: the line ends before the camera's focal length");
  WriteBytes(folder / "cameras.txt", "1 SIMPLE_RADIAL 60 40 50 30 20\n");
  ExpectError(read, "cameras.txt: line 1: the line ends before the camera's distortion");
  WriteBytes(folder / "cameras.txt", "1 PINHOLE 60 40 50 fifty 30 20\n");
  ExpectError(read, "cameras.txt: line 1: the camera's focal length is not a number");
  WriteBytes(folder / "cameras.txt", "-1 PINHOLE 60 40 50 50 30 20\n");
  ExpectError(read, "the camera's id is not a number that can be used");
  WriteBytes(folder / "cameras.txt", "1 PINHOLE 60000000000 40 50 50 30 20\n");
  ExpectError(read, "the camera's width is not a number that can be used");
}

}  // namespace
}  // namespace vesta::gs
