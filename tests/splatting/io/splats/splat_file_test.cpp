// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/splat_file.h"

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/io/bytes/bytes.h"
#include "tests/splatting/io/random_splat.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

TEST(SplatFile, TheExtensionSaysHowItIsWritten) {
  const TempFolder folder;
  const SplatModel model = RandomSplat(2, 10);
  for (const auto& [name, beginning] : {std::pair<const char*, const char*>{"a.ply", "element vertex"},
                                        {"a.spz", "NGSP"},
                                        {"a.compressed.ply", "element chunk"},
                                        {"a.sog", "PK"},
                                        {"a.glb", "glTF"},
                                        {"B.Compressed.PLY", "element chunk"},
                                        {"B.SPZ", "NGSP"}}) {
    WriteSplat(folder / name, model);
    EXPECT_THAT(ReadBytes(folder / name), testing::HasSubstr(beginning));
    if (std::string_view(name) == "a.glb") continue;  // not read
    const SplatModel again = ReadSplat(folder / name);
    EXPECT_EQ(again.count, 10);
    EXPECT_EQ(again.sh_degree, 2);
  }
  for (const char* name : {"a", "ply", "a.ksplat", "a.ply.gz", "a.ply/b"}) {
    EXPECT_THAT([&] { CheckSplatExtension(folder / name); }, ThrowsError(kBadArgument, folder / name));
    EXPECT_THAT([&] { WriteSplat(folder / name, model); }, ThrowsError(kBadArgument, folder / name));
  }
}

const char* const kWithoutY = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n";

TEST(SplatFile, WhatItHoldsSaysHowItIsRead) {
  const TempFolder folder;
  const SplatModel model = RandomSplat(1, 10);
  const std::string path = folder / "no_extension";
  for (const char* name : {"a.ply", "a.spz", "a.compressed.ply", "a.sog"}) {
    WriteSplat(folder / name, model);
    std::filesystem::copy_file(folder / name, path, std::filesystem::copy_options::overwrite_existing);
    EXPECT_EQ(ReadSplat(path).data, ReadSplat(folder / name).data);
  }
  for (const auto& [bytes, code, token] : {std::tuple<std::string, ErrorCode, std::string>{"", kBadFile, ".ply"},
                                           {"NGSP\x05", kBadFile, ""},
                                           {"a table", kBadFile, ".ksplat"},
                                           {Gzip("ply\nformat ascii 1.0\n", ""), kBadFile, ".ply"},
                                           {"\x1f\x8b", kBadFile, ""},
                                           {"PK", kBadFile, ""},
                                           {" {}", kBadFile, ".sog"},
                                           {"glTF", kUnsupported, ".glb"},
                                           {kWithoutY, kBadFile, "y"}}) {
    WriteBytes(path, bytes);
    EXPECT_THAT([&] { ReadSplat(path); }, ThrowsError(code, path, token));
  }
  // Without a magic number, the extension decides.
  WriteSplat(folder / "a.splat", model);
  EXPECT_EQ(ReadSplat(folder / "a.splat").count, 10);
  std::filesystem::copy_file(folder / "a.splat", path, std::filesystem::copy_options::overwrite_existing);
  EXPECT_THAT([&] { ReadSplat(path); }, ThrowsError(kBadFile, path, ".splat"));
  std::filesystem::copy_file(folder / "a.spz", folder / "b.splat");
  EXPECT_EQ(ReadSplat(folder / "b.splat").data, ReadSplat(folder / "a.spz").data);
  EXPECT_THAT([&] { ReadSplat(folder / "missing.spz"); }, ThrowsError(kNotFound, "missing.spz"));
}

TEST(SplatFile, TellsWhatIsBesideTheGaussians) {
  const TempFolder folder;
  SplatModel model = RandomSplat(0, 3);
  model.has_background = true;
  model.background = {1, 0.5f, 0.1f};
  model.eps2d = 0.1;
  model.origin = {448262.5, -5411932.0625, 1.0 / 3};
  for (const char* name : {"a.ply", "a.spz", "a.compressed.ply", "a.sog"}) {
    WriteSplat(folder / name, model);
    const SplatModel again = ReadSplat(folder / name);
    EXPECT_TRUE(again.has_background) << name;
    EXPECT_EQ(again.background, model.background) << name;
    EXPECT_EQ(again.origin, model.origin) << name;
    EXPECT_EQ(again.eps2d, 0.1) << name;
  }
}

// Formats have no per-Gaussian degree: missing bands are written as zeros, and zero bands removed on reading.
TEST(SplatFile, DegreesComeBack) {
  const TempFolder folder;
  std::vector<std::uint8_t> degrees;
  degrees.reserve(700);
  for (int i = 0; i < 700; ++i) degrees.push_back(static_cast<std::uint8_t>(i % 4));
  const SplatModel whole = RandomSplat(3, 700), mixed = TakeGaussians(whole, OrderByDegree(whole, degrees));
  WriteSplat(folder / "a.ply", mixed);
  const SplatModel again = ReadSplat(folder / "a.ply");
  EXPECT_EQ(again.layout(), mixed.layout());
  EXPECT_EQ(again.data, mixed.data);

  WriteSplat(folder / "a.spz", mixed);
  const SplatModel rounded = ReadSplat(folder / "a.spz");
  EXPECT_EQ(rounded.layout(), mixed.layout());
  for (int a = splat::kSh + 3; a < mixed.num_attributes(); ++a) {
    for (Index i = 0; i < mixed.Rows(a); ++i) EXPECT_NEAR(rounded.attribute(a)[i], mixed.attribute(a)[i], 1.0 / 256);
  }
  // This format has no exact zero, so all get the highest degree.
  WriteSplat(folder / "a.compressed.ply", mixed);
  const SplatModel coarse = ReadSplat(folder / "a.compressed.ply");
  EXPECT_TRUE(coarse.is_uniform());
  EXPECT_EQ(coarse.sh_degree, 3);
  EXPECT_EQ(coarse.count, mixed.count);
}

TEST(SplatFile, HasTheHighestDegreeThatThereIs) {
  const TempFolder folder;
  const SplatModel whole = RandomSplat(3, 5), mixed = TakeGaussians(whole, OrderByDegree(whole, {0, 1, 0, 0, 1}));
  for (const char* name : {"a.ply", "a.spz"}) {
    WriteSplat(folder / name, mixed);
    const SplatModel again = ReadSplat(folder / name);
    EXPECT_EQ(again.sh_degree, 1);
    EXPECT_EQ(again.layout(), mixed.layout());
  }
}

}  // namespace
}  // namespace vesta::gs
