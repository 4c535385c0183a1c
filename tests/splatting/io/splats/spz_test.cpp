// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/spz.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstring>

#include "splatting/io/bytes/bytes.h"
#include "splatting/io/splats/splat_file.h"
#include "splatting/io/splats/spz_rotation.h"
#include "tests/splatting/io/random_splat.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

std::string Unzipped(const std::string& path) {
  const std::string zipped = ReadBytes(path);
  GzipReader reader(path, zipped);
  std::string bytes(1'000'000, '\0');
  bytes.resize(reader.Read(bytes.data(), bytes.size()));
  return bytes;
}

std::string Bytes(std::initializer_list<int> values) {
  std::string bytes;
  for (const int value : values) bytes += static_cast<char>(value);
  return bytes;
}

// Between the rotations of Gaussian i of a and b, radians. Axes may be permuted, and log-scales differ by half a step.
// Infinite if no permutation fits.
double AngleAsGaussians(const SplatModel& a, const SplatModel& b, Index i) {
  double least = HUGE_VAL;
  for (const CubeTurn& turn : CubeTurns()) {
    SplatModel turned;
    turned.Resize(0, 1);
    std::array<double, 4> q{};
    for (std::size_t k = 0; k < 4; ++k) q[k] = a.attribute(splat::kQuaternion + static_cast<int>(k))[i];
    q = Product(q, turn.quaternion);
    bool fits = true;
    for (std::size_t k = 0; k < 4; ++k) {
      turned.attribute(splat::kQuaternion + static_cast<int>(k))[0] = static_cast<float>(q[k]);
      if (k == 3) break;
      const float scale = a.attribute(splat::kLogScale + turn.axes[k])[i];
      fits = fits && std::abs(scale - b.attribute(splat::kLogScale + static_cast<int>(k))[i]) <= 0.5f / 16 + 1e-6f;
    }
    if (fits) least = std::min(least, AngleBetween(turned, 0, b, i));
  }
  return least;
}

class Spz : public testing::Test {
 protected:
  TempFolder folder_;
  std::string path_ = folder_ / "a.spz";
};

// Also the largest difference of log-scales, unless rotations may permute them.
void ExpectWithinSteps(const SplatModel& model, const SplatModel& again, std::uint32_t version) {
  for (int k = 0; k < 3; ++k) {
    EXPECT_LE(LargestDifference(model, {}, again, splat::kMean + k), 0.5 / 4096 + 1e-6);
    EXPECT_LE(LargestDifference(model, {}, again, splat::kSh + k), 0.5 / (0.15 * 255) + 1e-6);
    if (version == kLatestSpz) {
      EXPECT_LE(LargestDifference(model, {}, again, splat::kLogScale + k), 0.5 / 16 + 1e-6);
    }
  }
  for (int a = splat::kSh + 3; a < model.num_attributes(); ++a) {
    EXPECT_LE(LargestDifference(model, {}, again, a), 0.5 / 128 + 1e-6);
  }
  for (Index i = 0; i < model.count; ++i) {
    EXPECT_NEAR(Opacity(again, i), Opacity(model, i), 0.5 / 255 + 1e-6);
    if (version == kLatestSpz) {
      EXPECT_LE(AngleBetween(model, i, again, i), 0.005);
    } else {
      EXPECT_LE(AngleAsGaussians(model, again, i), 0.014);
    }
  }
}

TEST_F(Spz, RoundTripStaysWithinItsSteps) {
  for (const std::uint32_t version : {kUniversalSpz, kLatestSpz}) {
    for (int degree = 0; degree <= 3; ++degree) {
      SCOPED_TRACE(testing::Message() << "version " << version << ", degree " << degree);
      SplatModel model = RandomSplat(degree, 3000);
      model.antialiased = degree % 2 == 1;
      WriteSpz(path_, model, version);
      const SplatModel again = ReadSpz(path_);
      ASSERT_EQ(again.count, model.count);
      ASSERT_EQ(again.sh_degree, degree);
      EXPECT_FALSE(again.has_background);
      EXPECT_EQ(again.antialiased, model.antialiased);
      ExpectWithinSteps(model, again, version);
      // Rounding a second time changes nothing.
      WriteSpz(folder_ / "b.spz", again, version);
      const SplatModel third = ReadSpz(folder_ / "b.spz");
      for (const int a : {0, 1, 2, 3, 4, 5, 10, 11, 12, 13}) EXPECT_EQ(LargestDifference(again, {}, third, a), 0) << a;
    }
  }
  EXPECT_THAT([&] { WriteSpz(path_, RandomSplat(0, 1), 1); }, ThrowsError(kBadArgument, "1"));
}

// Other programs rely on the exact bytes. Axes: x right, y up, z backward.
TEST_F(Spz, BytesAreTheFormats) {
  SplatModel model;
  model.Resize(1, 1);
  const auto set = [&](int a, std::initializer_list<float> values) {
    for (const float value : values) model.attribute(a++)[0] = value;
  };
  set(splat::kMean, {1, 2, -3});
  set(splat::kLogScale, {-5, -11, 0});
  set(splat::kQuaternion, {-0.938083152f, -0.2f, -0.2f, 0.2f});
  set(splat::kOpacity, {0});
  set(splat::kSh, {0, 1, -1, 0.5f, 0.25f, 0, -0.5f, 0, 0, 0.5f, 2, -2});
  WriteSpz(path_, model, kUniversalSpz);
  EXPECT_EQ(Unzipped(path_), "NGSP" + Bytes({2,   0,    0,   0,   1,    0,    0,   0,    1, 12, 0, 0,  //
                                             0,   0x10, 0,   0,   0xe0, 0xff, 0,   0x30, 0,
                                             128,                                               // opacity
                                             128, 166,  89,                                     // colour
                                             80,  0,    160,                                    // log-scales
                                             153, 102,  153,                                    // (0.2, -0.2, 0.2)
                                             64,  96,   128, 192, 128,  128,  192, 255,  0}));  // harmonics
}

// Versions 1 and 3 as other programs write them.
TEST_F(Spz, ReadsTheOtherVersions) {
  const std::string rest = Bytes({255, 128, 166, 89, 80, 0, 160});
  // 1, -2 and the smallest positive number as half floats.
  WriteBytes(path_, Gzip("NGSP" + Bytes({1, 0, 0, 0, 1, 0, 0, 0, 0, 12, 1, 0}) + Bytes({0, 0x3c, 0, 0xc0, 1, 0}) +
                             rest + Bytes({255, 128, 128}),
                         ""));
  SplatModel model = ReadSpz(path_);
  EXPECT_EQ(model.attribute(splat::kMean)[0], 1);
  EXPECT_EQ(model.attribute(splat::kMean + 1)[0], 2);
  EXPECT_EQ(model.attribute(splat::kMean + 2)[0], -0x1p-24f);
  EXPECT_NEAR(model.attribute(splat::kQuaternion)[0], 0, 0.1);
  EXPECT_EQ(model.attribute(splat::kQuaternion + 1)[0], 1);
  EXPECT_NEAR(Opacity(model, 0), 1, 0.5 / 255);
  EXPECT_TRUE(model.antialiased);
  EXPECT_NEAR(model.attribute(splat::kLogScale)[0], -5, 1e-6);

  // The largest component is y. The others, times sqrt(2): x = 0.5, z = -0.25, w = 0.5.
  const std::uint32_t rotation = 1u << 30 | 256u << 20 | (512u + 128) << 10 | 256u;
  std::string word(4, '\0');
  std::memcpy(word.data(), &rotation, 4);
  WriteBytes(path_, Gzip("NGSP" + Bytes({3, 0, 0, 0, 1, 0, 0, 0, 0, 10, 0, 0}) +
                             Bytes({0, 4, 0, 0, 8, 0, 255, 255, 255}) + rest + word,
                         ""));
  model = ReadSpz(path_);
  EXPECT_EQ(model.attribute(splat::kMean)[0], 1);
  EXPECT_EQ(model.attribute(splat::kMean + 1)[0], -2);
  EXPECT_EQ(model.attribute(splat::kMean + 2)[0], 1.0f / 1024);
  const double half = 0.70710678 * 256 / 511, quarter = half / 2,
               y = std::sqrt(1 - 2 * half * half - quarter * quarter);
  const double expected[] = {half, half, -y, quarter};  // rotated about x
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(model.attribute(splat::kQuaternion + k)[0], expected[k], 1e-6);
}

TEST_F(Spz, FractionBitsFollowTheScene) {
  const auto bits_of = [&](float mean, float log_scale) {
    SplatModel model = RandomSplat(0, 5);
    std::fill_n(model.attribute(splat::kLogScale), 15, log_scale);
    model.attribute(splat::kMean)[2] = mean;
    WriteSpz(path_, model);
    EXPECT_NEAR(ReadSpz(path_).attribute(splat::kMean)[2], mean, std::abs(mean) * 1e-6 + 1e-4);
    return static_cast<int>(ReadBytes(path_)[13]);
  };
  EXPECT_EQ(bits_of(1, -3), 12);
  EXPECT_EQ(bits_of(2047.9f, -3), 12);
  EXPECT_EQ(bits_of(-2048, -3), 11);
  EXPECT_EQ(bits_of(2e5f, -1), 5);
  EXPECT_EQ(bits_of(8388607, 3), 0);
  EXPECT_EQ(bits_of(1, -9), 16);  // e^-9 / 8 is 2^-15.98
}

TEST_F(Spz, WhatDoesNotFitIsRefusedAndTheOldFileStays) {
  WriteBytes(path_, "old");
  const auto refused = [&](const auto& change, const std::string& token) {
    SplatModel model = RandomSplat(1, 5);
    change(&model);
    EXPECT_THAT([&] { WriteSpz(path_, model); }, ThrowsError(kBadArgument, path_, token));
    EXPECT_EQ(ReadBytes(path_), "old");
  };
  refused([](SplatModel* m) { m->attribute(splat::kMean)[1] = 9e6f; }, "9e+06");
  refused([](SplatModel* m) { m->attribute(splat::kMean)[1] = -3e38f; }, "3e+38");
  refused([](SplatModel* m) { m->attribute(splat::kMean)[1] = 1e6f; }, "1e+06");
  refused([](SplatModel* m) { m->attribute(splat::kSh)[1] = std::nanf(""); }, "5");
  refused([](SplatModel* m) { m->attribute(splat::kOpacity)[1] = HUGE_VALF; }, "5");
  refused([](SplatModel* m) { std::fill_n(m->attribute(splat::kLogScale), 15, -12.0f); }, "e^-12");
  refused([](SplatModel* m) { std::fill_n(m->attribute(splat::kLogScale), 15, 9.0f); }, "e^9");
  refused([](SplatModel* m) { m->Resize(1, 0); }, "");
  EXPECT_THAT([&] { WriteSpz(folder_ / "none/a.spz", RandomSplat(0, 1)); }, ThrowsError(kCannotWrite, "none/a.spz"));
}

// Values beyond the range of the format.
TEST_F(Spz, ValuesAreClamped) {
  SplatModel model = RandomSplat(1, 5);
  model.attribute(splat::kLogScale)[0] = -30;
  model.attribute(splat::kLogScale)[1] = 40;
  model.attribute(splat::kSh)[0] = 1e30f;
  model.attribute(splat::kSh + 3)[0] = -1e30f;
  WriteSpz(path_, model);
  const SplatModel again = ReadSpz(path_);
  const auto scales_of = [&](Index i) {
    return std::array<float, 3>{again.attribute(splat::kLogScale)[i], again.attribute(splat::kLogScale + 1)[i],
                                again.attribute(splat::kLogScale + 2)[i]};
  };
  EXPECT_THAT(scales_of(0), testing::Contains(-10));
  EXPECT_THAT(scales_of(1), testing::Contains(5.9375f));
  EXPECT_NEAR(again.attribute(splat::kSh)[0], 3.333, 1e-3);
  EXPECT_NEAR(again.attribute(splat::kSh + 3)[0], -1, 0.01);
}

}  // namespace
}  // namespace vesta::gs
