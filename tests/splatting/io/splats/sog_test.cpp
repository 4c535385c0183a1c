// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/sog.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "problems/gaussian_splatting/model/initialize.h"
#include "splatting/io/bytes/zip.h"
#include "splatting/io/images/image_codecs.h"
#include "splatting/io/splats/compressed_ply.h"
#include "tests/splatting/io/random_splat.h"
#include "tests/splatting/io/sog_example.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

using nlohmann::json;
using testing::ElementsAre;

class Sog : public testing::Test {
 protected:
  json Meta() const { return json::parse(ZipReader(path_, bundle_).Read("meta.json")); }
  InterleavedImage ImageOf(const char* name) const {
    return DecodeWebp(name, ZipReader(path_, bundle_).Read(name), false);
  }
  void Write(const SplatModel& model) {
    WriteSog(path_, model);
    bundle_ = ReadBytes(path_);
  }

  TempFolder folder_;
  std::string path_ = folder_ / "a.sog", bundle_;
};

TEST_F(Sog, RoundTripStaysWithinItsSteps) {
  constexpr Index kCount = 2048;  // a power of two: each Gaussian has its own entry in the SH palette
  for (int degree = 0; degree <= 3; ++degree) {
    SCOPED_TRACE(degree);
    const SplatModel model = RandomSplat(degree, kCount);
    Write(model);
    const SplatModel again = ReadSog(path_);
    ASSERT_EQ(again.layout(), model.layout());
    EXPECT_FALSE(again.has_background || again.antialiased);
    const std::vector<Index> order = ChunkOrder(model, 256);
    // The step of log(1 + |x|) is 2 log(5) / 65535, and x is up to 5 times as steep.
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE(LargestDifference(model, order, again, splat::kMean + k), 5 * std::log(5) / 65535 + 1e-6);
      EXPECT_LE(LargestDifference(model, order, again, splat::kLogScale + k), 5.0 / 256);
      EXPECT_LE(LargestDifference(model, order, again, splat::kSh + k), 4.0 / 256);
    }
    for (int a = splat::kSh + 3; a < model.num_attributes(); ++a) {
      EXPECT_LE(LargestDifference(model, order, again, a), 1.9 / 256);
    }
    for (Index i = 0; i < kCount; ++i) {
      const Index from = order[static_cast<std::size_t>(i)];
      EXPECT_NEAR(Opacity(again, i), Opacity(model, from), 0.5 / 255 + 1e-6);
      EXPECT_LE(AngleBetween(model, from, again, i), 0.016);
    }
  }
}

// Other programs rely on the exact values.
TEST_F(Sog, PixelsAreTheFormats) {
  SplatModel model;
  model.Resize(1, 2);
  const auto set = [&](int a, Index i, std::initializer_list<float> values) {
    for (const float value : values) model.attribute(a++)[i] = value;
  };
  set(splat::kMean, 0, {0, -1.71828183f, 2});  // 1 - e
  set(splat::kMean, 1, {6.3890561f, 0, 2});    // e^2 - 1
  set(splat::kLogScale, 0, {-5, -3, -5});
  set(splat::kLogScale, 1, {-4, -4, -3});
  set(splat::kQuaternion, 0, {-1, 0, 0, 0});
  set(splat::kQuaternion, 1, {0.5f, 0.5f, 0.5f, -0.6f});
  set(splat::kOpacity, 0, {0});
  set(splat::kOpacity, 1, {-30});
  set(splat::kSh, 0, {0.25f, 0.5f, 0.75f, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  set(splat::kSh, 1, {0.25f, 0.5f, -1, -1, -2, -3, 4, 5, 6, 7, 8, 9});
  Write(model);
  const json meta = Meta();
  EXPECT_EQ(meta["version"], 2);
  EXPECT_EQ(meta["count"], 2);
  EXPECT_FALSE(meta.contains("antialias") || meta.contains("model") || meta.contains("extras"));
  EXPECT_NEAR(meta["means"]["mins"][1], -1, 1e-7);
  EXPECT_NEAR(meta["means"]["maxs"][0], 2, 1e-7);
  EXPECT_EQ(meta["shN"]["count"], 2);
  EXPECT_EQ(meta["shN"]["bands"], 1);
  for (const char* property : {"scales", "sh0", "shN"}) EXPECT_EQ(meta[property]["codebook"].size(), 256u) << property;
  const auto samples = [&](const char* name, std::size_t first, std::size_t count) {
    const auto bytes = ImageOf(name).bytes;
    return std::vector<int>(bytes.begin() + static_cast<std::ptrdiff_t>(first),
                            bytes.begin() + static_cast<std::ptrdiff_t>(first + count));
  };
  EXPECT_EQ(ImageOf("means_l.webp").size.width, 4);
  EXPECT_EQ(ImageOf("means_l.webp").size.height, 4);
  EXPECT_THAT(samples("means_l.webp", 0, 6), ElementsAre(0, 0, 0, 255, 255, 0));
  EXPECT_THAT(samples("means_u.webp", 0, 6), ElementsAre(0, 0, 0, 255, 255, 0));
  EXPECT_THAT(samples("scales.webp", 0, 6), ElementsAre(0, 2, 0, 1, 1, 2));
  EXPECT_THAT(samples("sh0.webp", 0, 8), ElementsAre(1, 2, 3, 128, 1, 2, 0, 0));
  // The largest number becomes positive; the others are divided by its greatest possible share, 1/sqrt(2).
  const double part = 0.5 / std::sqrt(3 * 0.25 + 0.36) * std::sqrt(2.0);
  const int byte = static_cast<int>(std::lround(127.5 * (1 - part)));
  EXPECT_THAT(samples("quats.webp", 0, 8), ElementsAre(128, 128, 128, 252, byte, byte, byte, 255));
  EXPECT_THAT(samples("shN_labels.webp", 0, 6), ElementsAre(0, 0, 0, 1, 0, 0));
  EXPECT_EQ(ImageOf("shN_centroids.webp").size.width, 64 * 3);
  EXPECT_EQ(ImageOf("shN_centroids.webp").size.height, 1);
  EXPECT_THAT(samples("shN_centroids.webp", 0, 18),
              ElementsAre(3, 4, 5, 6, 7, 8, 9, 10, 11, 2, 1, 0, 6, 7, 8, 9, 10, 11));
  // All of this is exact, except for the means and rotations.
  const SplatModel again = ReadSog(path_);
  EXPECT_NEAR(again.attribute(splat::kMean)[1], 6.3890561, 1e-6);
  EXPECT_NEAR(again.attribute(splat::kMean + 1)[0], -1.71828183, 1e-6);
  EXPECT_EQ(LargestDifference(model, {}, again, splat::kMean + 2), 0);
  for (int a = splat::kSh; a < model.num_attributes(); ++a) EXPECT_EQ(LargestDifference(model, {}, again, a), 0) << a;
}

// A file as other programs write it (sog_example.h).
TEST_F(Sog, ReadsTheExample) {
  WriteBytes(path_, Zip(SogExample().Entries()));
  const SplatModel model = ReadSog(path_);
  ASSERT_EQ(model.count, 2);
  ASSERT_EQ(model.sh_degree, 1);
  EXPECT_NEAR(model.attribute(splat::kMean)[0], 1 - std::exp(1), 1e-6);
  EXPECT_NEAR(model.attribute(splat::kMean)[1], 1 - std::exp(1 - 2.0 * 0x1234 / 0xffff), 1e-6);
  EXPECT_NEAR(model.attribute(splat::kMean + 2)[1], std::exp(2) - 1, 1e-5);
  EXPECT_EQ(model.attribute(splat::kLogScale)[0], -6);
  EXPECT_EQ(model.attribute(splat::kLogScale + 1)[1], -5);
  EXPECT_EQ(model.attribute(splat::kSh)[0], 0.5f);
  EXPECT_NEAR(Opacity(model, 1), 51 / 255.0, 1e-6);
  // The three numbers after the largest, x.
  const double most = 1 / std::sqrt(2.0);
  EXPECT_NEAR(model.attribute(splat::kQuaternion)[1], most * (2 * 153 / 255.0 - 1), 1e-6);
  EXPECT_NEAR(model.attribute(splat::kQuaternion + 2)[1], most * (2 * 102 / 255.0 - 1), 1e-6);
  EXPECT_GT(model.attribute(splat::kQuaternion + 1)[1], 0.9f);
  // Label 65 is the second entry in the second row of the palette.
  EXPECT_EQ(model.attribute(splat::kSh + 3)[0], 0.25f);
  EXPECT_EQ(model.attribute(splat::kSh + 3 + 8)[1], -0.25f);
}

TEST_F(Sog, FilesOfAFolderAreRead) {
  for (const auto& [name, bytes] : SogExample().Entries()) WriteBytes(folder_ / name, bytes);
  WriteBytes(path_, Zip(SogExample().Entries()));
  const SplatModel model = ReadSplat(folder_ / "meta.json");
  EXPECT_EQ(model.data, ReadSplat(path_).data);
  std::filesystem::remove(folder_ / "quats.webp");
  EXPECT_THAT([&] { ReadSog(folder_ / "meta.json"); }, ThrowsError(kNotFound, "quats.webp"));
}

TEST_F(Sog, AntialiasingIsStoredTwice) {
  SplatModel model = RandomSplat(0, 3);
  model.antialiased = true;
  Write(model);
  EXPECT_EQ(Meta()["antialias"], true);
  EXPECT_EQ(Meta()["model"], "antialiased");
  EXPECT_TRUE(ReadSog(path_).antialiased);
  for (const auto& [key, value, expected] : {std::tuple<const char*, json, bool>{"antialias", true, true},
                                             {"antialias", false, false},
                                             {"model", "antialiased", true},
                                             {"model", "default", false},
                                             {"model", 1, false}}) {
    SogExample example;
    example.meta[key] = value;
    WriteBytes(path_, Zip(example.Entries()));
    EXPECT_EQ(ReadSog(path_).antialiased, expected) << key << value;
  }
}

// Early files have null as the first number of a codebook.
TEST_F(Sog, ANullInFrontIsReplaced) {
  SogExample example;
  json& codebook = example.meta["scales"]["codebook"];
  codebook = json::array({nullptr});
  for (int i = 1; i < 256; ++i) codebook.push_back(i);
  WriteBytes(path_, Zip(example.Entries()));
  EXPECT_NEAR(ReadSog(path_).attribute(splat::kLogScale)[0], 1 + (1 - 255) / 255.0, 1e-6);
}

// The second Gaussian has a byte without a number, or an unknown tag of the rotation.
TEST_F(Sog, GaussiansWithoutValuesAreLeftOut) {
  SogExample short_codebook, unknown_tag;
  short_codebook.meta["scales"]["codebook"].erase(1);
  unknown_tag.rotations[7] = 200;
  for (const SogExample& example : {short_codebook, unknown_tag}) {
    WriteBytes(path_, Zip(example.Entries()));
    std::vector<std::string> notes;
    EXPECT_EQ(ReadSog(path_, &notes).count, 1);
    EXPECT_THAT(notes, ElementsAre(HasTokens(path_, "1", "2")));
  }
}

TEST_F(Sog, WhatCannotBeStoredIsRefusedAndTheOldFileStays) {
  WriteBytes(path_, "old");
  SplatModel model = RandomSplat(1, 5);
  model.attribute(splat::kSh)[1] = std::nanf("");
  EXPECT_THAT([&] { WriteSog(path_, model); }, ThrowsError(kBadArgument, path_, "5"));
  model.Resize(1, 0);
  EXPECT_THAT([&] { WriteSog(path_, model); }, ThrowsError(kBadArgument, path_));
  EXPECT_EQ(ReadBytes(path_), "old");
}

TEST_F(Sog, ExtremeValuesSurvive) {
  SplatModel model = RandomSplat(1, 40);
  model.attribute(splat::kMean)[3] = 3e38f;
  model.attribute(splat::kLogScale)[4] = -1e30f;
  model.attribute(splat::kSh)[5] = 1e38f;
  model.attribute(splat::kSh + 4)[6] = -3e38f;
  Write(model);
  EXPECT_EQ(ReadSog(path_).count, 40);
}

}  // namespace
}  // namespace vesta::gs
