// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/ply.h"

#include <random>

#include "tests/splatting/io/test_ply.h"

namespace vesta::gs {
namespace {

TEST(SplatPly, RoundTripIsExactForEveryDegree) {
  const TempFolder folder;
  for (int degree = 0; degree <= 3; ++degree) {
    SplatModel model = ExampleSplat(degree, 5000);
    model.has_background = degree % 2 == 1;
    if (model.has_background) model.background = {0.613f, 1.0f / 3, 0};
    if (degree > 1) model.eps2d = 1.0 / 7;
    model.antialiased = degree > 0;
    WriteSplatPly(folder / "a.ply", model);
    const SplatModel again = ReadSplatPly(folder / "a.ply");
    EXPECT_EQ(again.sh_degree, degree);
    EXPECT_EQ(again.count, model.count);
    EXPECT_EQ(again.data, model.data);
    EXPECT_EQ(again.has_background, model.has_background);
    EXPECT_EQ(again.background, model.background);
    EXPECT_EQ(again.eps2d, model.eps2d);
    EXPECT_EQ(again.antialiased, model.antialiased);
    WriteSplatPly(folder / "b.ply", again);
    EXPECT_EQ(ReadBytes(folder / "a.ply"), ReadBytes(folder / "b.ply"));
  }
}

// The origin of a model far from the origin of the scene's frame is saved.
TEST(SplatPly, TellsItsOrigin) {
  const TempFolder folder;
  SplatModel model;
  model.Resize(0, 1);
  model.attribute(splat::kQuaternion)[0] = 1;
  WriteSplatPly(folder / "a.ply", model);
  EXPECT_THAT(ReadBytes(folder / "a.ply"), testing::Not(testing::HasSubstr("origin")));
  model.origin = {448262.5, -5411932.0625, 1.0 / 3};
  WriteSplatPly(folder / "b.ply", model);
  EXPECT_THAT(ReadBytes(folder / "b.ply"), testing::HasSubstr("comment vesta origin 448262.5 -5411932.0625 0.333"));
  EXPECT_EQ(ReadSplatPly(folder / "b.ply").origin, model.origin);
}

// Comments as Brush writes them.
TEST(SplatPly, ReadsTheRenderModeOfOtherPrograms) {
  const TempFolder folder;
  std::string properties;
  for (const char* name : {"x", "y", "z", "scale_0", "scale_1", "scale_2", "opacity", "rot_0", "rot_1", "rot_2",
                           "rot_3", "f_dc_0", "f_dc_1", "f_dc_2"}) {
    properties += std::string("property float ") + name + "\n";
  }
  for (const auto& [comment, antialiased] : {std::pair{"comment SplatRenderMode: mip\n", true},
                                             {"comment SplatRenderMode: default\n", false},
                                             {"", false}}) {
    WriteBytes(folder / "a.ply", std::string("ply\nformat ascii 1.0\ncomment Exported from Brush\n") + comment +
                                     "comment Vertical axis: y\nelement vertex 1\n" + properties +
                                     "end_header\n1 2 3 -2 -3 -4 0.5 1 0 0 0 0.1 0.2 0.3\n");
    EXPECT_EQ(ReadSplatPly(folder / "a.ply").antialiased, antialiased) << comment;
  }
}

// By name, because other programs rely on them.
TEST(SplatPly, LayoutIsInrias) {
  const TempFolder folder;
  SplatModel model;
  model.Resize(1, 1);
  for (int a = 0; a < model.num_attributes(); ++a) model.attribute(a)[0] = static_cast<float>(a);
  model.has_background = true;
  model.background = {1, 0.5f, 0};
  WriteSplatPly(folder / "a.ply", model);
  const std::string bytes = ReadBytes(folder / "a.ply");
  EXPECT_THAT(bytes, testing::StartsWith("ply\nformat binary_little_endian 1.0\ncomment vesta background 1 0.5 0\n"
                                         "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                                         "property float nx\nproperty float ny\nproperty float nz\n"
                                         "property float f_dc_0\n"));
  const std::string values = bytes.substr(bytes.find("end_header\n") + 11);
  ASSERT_EQ(values.size(), 26 * sizeof(float));
  std::vector<float> row(26);
  std::memcpy(row.data(), values.data(), values.size());
  // Coefficient k of channel c is attribute 11 + 3 k + c; f_rest is channel by channel.
  const std::vector<float> expected{0,  1,  2,  0,  0,  0,  11, 12, 13, 14, 17, 20, 15,
                                    18, 21, 16, 19, 22, 10, 3,  4,  5,  6,  7,  8,  9};
  EXPECT_EQ(row, expected);
}

TEST(SplatPly, ReadsAnyOrderTypeAndExtraProperties) {
  const TempFolder folder;
  const std::string header =
      "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nelement vertex 2\r\nproperty double rot_0\r\n"
      "property float rot_1\r\nproperty float rot_2\r\nproperty float rot_3\r\nproperty float opacity\r\n"
      "property uchar extra\r\nproperty float scale_2\r\nproperty float scale_1\r\nproperty float scale_0\r\n"
      "property float f_dc_0\r\nproperty float f_dc_1\r\nproperty float f_dc_2\r\nproperty int z\r\nproperty float "
      "y\r\n"
      "property float x\r\nelement face 0\r\nproperty list uchar int vertex_indices\r\nend_header\r\n";
  WriteBytes(folder / "a.ply", header + "6 7 8 9 10 99 5 4 3 11 12 13 2 1 0\r\n 0.5 0 0 0 1e-3 0 0 0 0 -1 0 0 0 0 0");
  const SplatModel model = ReadSplatPly(folder / "a.ply");
  ASSERT_EQ(model.count, 2);
  EXPECT_EQ(model.sh_degree, 0);
  EXPECT_FALSE(model.has_background);
  for (int a = 0; a < 14; ++a) EXPECT_EQ(model.attribute(a)[0], static_cast<float>(a)) << a;
  EXPECT_EQ(model.attribute(splat::kQuaternion)[1], 0.5f);
  EXPECT_EQ(model.attribute(splat::kOpacity)[1], 1e-3f);
  EXPECT_EQ(model.attribute(splat::kSh)[1], -1);
}

TEST(SplatPly, UnusableGaussiansAreLeftOutWithANote) {
  const TempFolder folder;
  SplatModel model = ExampleSplat(1, 7);
  model.attribute(20)[1] = std::nanf("");
  model.attribute(splat::kLogScale)[3] = HUGE_VALF;
  for (int a = 0; a < 4; ++a) model.attribute(splat::kQuaternion + a)[4] = 0;
  model.attribute(splat::kLogScale + 2)[6] = -HUGE_VALF;
  WriteSplatPly(folder / "a.ply", model);
  std::vector<std::string> notes;
  const SplatModel kept = ReadSplatPly(folder / "a.ply", &notes);
  ASSERT_EQ(kept.count, 3);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_THAT(notes[0], testing::HasSubstr("4 of 7"));
  for (int a = 0; a < model.num_attributes(); ++a) {
    EXPECT_EQ(kept.attribute(a)[0], model.attribute(a)[0]);
    EXPECT_EQ(kept.attribute(a)[1], model.attribute(a)[2]);
    EXPECT_EQ(kept.attribute(a)[2], model.attribute(a)[5]);
  }
}

// Programs that unpack compact files write infinite logits for 0 and 1.
TEST(SplatPly, OpacitiesMayBeInfinite) {
  const TempFolder folder;
  SplatModel model = ExampleSplat(0, 3);
  model.attribute(splat::kOpacity)[0] = HUGE_VALF;
  model.attribute(splat::kOpacity)[1] = -HUGE_VALF;
  WriteSplatPly(folder / "a.ply", model);
  SplatModel again = ReadSplatPly(folder / "a.ply");
  EXPECT_NEAR(again.attribute(splat::kOpacity)[0], 6.9, 0.1);
  EXPECT_NEAR(again.attribute(splat::kOpacity)[1], -6.9, 0.1);
  EXPECT_EQ(again.attribute(splat::kOpacity)[2], model.attribute(splat::kOpacity)[2]);
  model.attribute(splat::kOpacity)[0] = std::nanf("");
  WriteSplatPly(folder / "a.ply", model);
  EXPECT_EQ(ReadSplatPly(folder / "a.ply").count, 2);
  for (Index i = 0; i < 3; ++i) model.attribute(splat::kOpacity)[i] = std::nanf("");
  WriteSplatPly(folder / "a.ply", model);
  EXPECT_THAT([&] { ReadSplatPly(folder / "a.ply"); }, ThrowsError(kBadFile, "a.ply", "3"));
}

TEST(SplatPly, TwoScalesMakeDisksAndColoursReplaceHarmonics) {
  const TempFolder folder;
  WriteBytes(folder / "a.ply",
             "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
             "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float opacity\n"
             "property float scale_0\nproperty float scale_1\nproperty float rot_0\nproperty float rot_1\n"
             "property float rot_2\nproperty float rot_3\nend_header\n1 2 3 255 0 51 0.5 -2 -3 1 0 0 0\n");
  const SplatModel model = ReadSplatPly(folder / "a.ply");
  ASSERT_EQ(model.count, 1);
  EXPECT_EQ(model.sh_degree, 0);
  EXPECT_FLOAT_EQ(model.Value(splat::kLogScale + 2, 0), -3 - std::log(1000.0f));
  for (const auto& [channel, color] : {std::pair{0, 1.0}, {1, 0.0}, {2, 0.2}}) {
    EXPECT_NEAR(0.5 + 0.28209479177387814 * static_cast<double>(model.Value(splat::kSh + channel, 0)), color, 1e-6);
  }
}

TEST(PointPly, ColoursOfEveryKind) {
  const TempFolder folder;
  const auto write = [&](const std::string& type, const std::string& values) {
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    for (const char* name : {"red", "green", "blue"}) {
      if (!type.empty()) text += "property " + type + " " + name + "\n";
    }
    WriteBytes(folder / "p.ply", text + "end_header\n1 2 3 " + values + "\n");
  };
  const std::array<float, 3> expected{1, 0, 0.2f};
  write("uchar", "255 0 51");
  EXPECT_EQ(ReadPointPly(folder / "p.ply").colors[0], expected);
  write("float", "1 0 0.2");
  EXPECT_EQ(ReadPointPly(folder / "p.ply").colors[0], expected);
  write("", "");
  EXPECT_EQ(ReadPointPly(folder / "p.ply").colors[0], (std::array<float, 3>{0.5f, 0.5f, 0.5f}));
  EXPECT_EQ(ReadPointPly(folder / "p.ply").positions[0], (std::array<double, 3>{1, 2, 3}));
  write("float", "nan 0 0");
  EXPECT_THAT([&] { ReadPointPly(folder / "p.ply"); }, ThrowsError(kBadFile, "p.ply", "1"));
}

TEST(PointPly, PointsThatAreNotFiniteAreLeftOutWithANote) {
  const TempFolder folder;
  WriteBytes(folder / "p.ply",
             "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty double z\n"
             "property uchar diffuse_red\nproperty uchar diffuse_green\nproperty uchar diffuse_blue\nend_header\n"
             "1 2 nan 255 0 51\n1 2 3 255 0 51\n1 2 1e39 255 0 51\n");
  std::vector<std::string> notes;
  const WorldPoints cloud = ReadPointPly(folder / "p.ply", &notes);
  ASSERT_EQ(cloud.positions.size(), 1u);
  EXPECT_EQ(cloud.positions[0], (std::array<double, 3>{1, 2, 3}));
  EXPECT_EQ(cloud.colors[0], (std::array<float, 3>{1, 0, 0.2f}));
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_THAT(notes[0], testing::HasSubstr("2 of 3"));
}

}  // namespace
}  // namespace vesta::gs
