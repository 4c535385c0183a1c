// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/compressed_ply.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <numeric>

#include "problems/gaussian_splatting/model/initialize.h"
#include "splatting/io/splats/ply.h"
#include "tests/splatting/io/random_splat.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

class CompressedPly : public testing::Test {
 protected:
  SplatModel Read() const { return ReadCompressedPly(PlyFile(path_)); }

  TempFolder folder_;
  std::string path_ = folder_ / "a.compressed.ply";
};

// Over the Gaussians [begin, end) of an order.
double Extent(const SplatModel& model, const std::vector<Index>& order, Index begin, Index end, int attribute) {
  double low = 1e300, high = -1e300;
  for (Index i = begin; i < end; ++i) {
    const double value = model.attribute(attribute)[order[static_cast<std::size_t>(i)]];
    low = std::min(low, value);
    high = std::max(high, value);
  }
  return high - low;
}

TEST_F(CompressedPly, RoundTripStaysWithinItsSteps) {
  constexpr Index kCount = 1000, kChunk = 256;
  for (int degree = 0; degree <= 3; ++degree) {
    SCOPED_TRACE(degree);
    SplatModel model = RandomSplat(degree, kCount);
    model.antialiased = degree % 2 == 1;
    WriteCompressedPly(path_, model);
    const SplatModel again = Read();
    ASSERT_EQ(again.count, kCount);
    ASSERT_EQ(again.sh_degree, degree);
    EXPECT_EQ(again.antialiased, model.antialiased);
    const std::vector<Index> order = ChunkOrder(model, kChunk);
    const std::pair<int, double> steps[] = {
        {splat::kMean, 2047},     {splat::kMean + 1, 1023},     {splat::kMean + 2, 2047},
        {splat::kLogScale, 2047}, {splat::kLogScale + 1, 1023}, {splat::kLogScale + 2, 2047},
        {splat::kSh, 255},        {splat::kSh + 1, 255},        {splat::kSh + 2, 255}};
    for (Index begin = 0; begin < kCount; begin += kChunk) {
      const Index end = std::min(begin + kChunk, kCount);
      for (const auto& [attribute, steps_of] : steps) {
        const double half_step = 0.5 * Extent(model, order, begin, end, attribute) / steps_of;
        for (Index i = begin; i < end; ++i) {
          EXPECT_NEAR(again.attribute(attribute)[i], model.attribute(attribute)[order[static_cast<std::size_t>(i)]],
                      half_step + 2e-6);
        }
      }
    }
    for (int a = splat::kSh + 3; a < model.num_attributes(); ++a) {
      EXPECT_LE(LargestDifference(model, order, again, a), 1.5 / 64 + 1e-6);
    }
    for (Index i = 0; i < kCount; ++i) {
      const Index from = order[static_cast<std::size_t>(i)];
      EXPECT_NEAR(Opacity(again, i), Opacity(model, from), 0.5 / 255 + 1e-6);
      // Three components have an error of half a step each; the largest, computed from them, at most their sum.
      EXPECT_LE(AngleBetween(again, i, model, from), 2 * 2 * std::sqrt(3.0) * 0.5 / 723);
    }
  }
}

// Other programs rely on the exact bytes.
TEST_F(CompressedPly, BytesAreTheFormats) {
  SplatModel model;
  model.Resize(1, 2);
  const auto set = [&](int a, float first, float second) {
    model.attribute(a)[0] = first;
    model.attribute(a)[1] = second;
  };
  set(splat::kMean, 1, 3), set(splat::kMean + 1, -2, -2), set(splat::kMean + 2, 9, 5);
  set(splat::kLogScale, -3, -3), set(splat::kLogScale + 1, -5, -4), set(splat::kLogScale + 2, -4, -5);
  set(splat::kQuaternion, 1, 0), set(splat::kQuaternion + 2, 0, -2);
  set(splat::kOpacity, 0, 100);
  set(splat::kSh, 0, 0), set(splat::kSh + 1, 1, 2), set(splat::kSh + 2, 2, 1);
  set(splat::kSh + 3, -4, 4), set(splat::kSh + 4, 0, 0.5f), set(splat::kSh + 5, 9, -9);
  WriteCompressedPly(path_, model);
  const std::string bytes = ReadBytes(path_);
  std::string header = "ply\nformat binary_little_endian 1.0\nelement chunk 1\n";
  for (const std::string of : {"", "scale_"}) {
    for (const char* end : {"min_", "max_"}) {
      for (const char* axis : {"x", "y", "z"}) header += "property float " + (end + of) + axis + "\n";
    }
  }
  for (const std::string end : {"min_", "max_"}) {
    for (const char* channel : {"r", "g", "b"}) header += "property float " + end + channel + "\n";
  }
  header += "element vertex 2\n";
  for (const char* what : {"position", "rotation", "scale", "color"}) {
    header += std::string("property uint packed_") + what + "\n";
  }
  header += "element sh 2\n";
  for (int i = 0; i < 9; ++i) header += "property uchar f_rest_" + std::to_string(i) + "\n";
  header += "end_header\n";
  ASSERT_EQ(bytes.substr(0, header.size()), header);
  ASSERT_EQ(bytes.size(), header.size() + 18 * 4 + 2 * 16 + 2 * 9);
  std::array<float, 18> bounds;
  std::array<std::uint32_t, 8> words;
  std::memcpy(bounds.data(), bytes.data() + header.size(), sizeof(bounds));
  std::memcpy(words.data(), bytes.data() + header.size() + sizeof(bounds), sizeof(words));
  const float green = 0.5f + 0.2820948f, more = 0.5f + 2 * 0.2820948f;
  const std::array<float, 18> expected{1,  -2, 5,  3,    -2,    9,     -3,   -5,   -5,
                                       -3, -4, -4, 0.5f, green, green, 0.5f, more, more};
  for (std::size_t k = 0; k < 18; ++k) EXPECT_NEAR(bounds[k], expected[k], 1e-6f) << k;
  // Two Gaussians in one chunk keep their order.
  EXPECT_EQ(words[0], 0u << 21 | 0u << 11 | 2047u);
  EXPECT_EQ(words[1], 0u << 30 | 512u << 20 | 512u << 10 | 512u);
  EXPECT_EQ(words[2], 0u << 21 | 0u << 11 | 2047u);
  EXPECT_EQ(words[3], 0u << 24 | 0u << 16 | 255u << 8 | 128u);
  EXPECT_EQ(words[4], 2047u << 21 | 0u << 11 | 0u);
  EXPECT_EQ(words[5], 2u << 30 | 512u << 20 | 512u << 10 | 512u);
  EXPECT_EQ(words[6], 0u << 21 | 1023u << 11 | 0u);
  EXPECT_EQ(words[7], 0u << 24 | 255u << 16 | 0u << 8 | 254u);
  const std::string sh = bytes.substr(bytes.size() - 18);
  EXPECT_EQ(sh.substr(0, 9), std::string("\x00\x80\x80\x80\x80\x80\xff\x80\x80", 9));
  EXPECT_EQ(sh.substr(9), std::string("\xff\x7f\x7f\x8f\x7f\x7f\x00\x7f\x7f", 9));
}

// 0 lies between two byte values. Rounding all to the same one would change the colour.
TEST_F(CompressedPly, ErrorsOfHarmonicsCancel) {
  SplatModel model = RandomSplat(1, 256);
  for (int a = splat::kSh + 3; a < model.num_attributes(); ++a) std::fill_n(model.attribute(a), 256, 0.0f);
  std::fill_n(model.attribute(splat::kSh + 3), 256, 0.3f);
  WriteCompressedPly(path_, model);
  const SplatModel again = Read();
  for (int a = splat::kSh + 3; a < model.num_attributes(); ++a) {
    double sum = 0;
    for (Index i = 0; i < 256; ++i) sum += static_cast<double>(again.attribute(a)[i] - model.attribute(a)[i]);
    EXPECT_LT(std::abs(sum / 256), 1.0 / 256) << a;
  }
}

// The first version of the format: colours in 0..1, no SH.
TEST_F(CompressedPly, ReadsChunksWithoutColours) {
  SplatModel model = RandomSplat(0, 1);
  WriteCompressedPly(path_, model);
  std::string bytes = ReadBytes(path_);
  for (const char* bound : {"min_r", "min_g", "min_b", "max_r", "max_g", "max_b"}) {
    const std::string line = std::string("property float ") + bound + "\n";
    bytes.erase(bytes.find(line), line.size());
  }
  bytes.erase(bytes.find("end_header\n") + 11 + 12 * 4, 6 * 4);
  bytes.replace(bytes.size() - 4, 4, std::string("\x80\x00\xff\x40", 4));  // opacity, then blue, green, red
  WriteBytes(path_, bytes);
  const SplatModel again = Read();
  EXPECT_NEAR(again.attribute(splat::kSh)[0], (0x40 / 255.0 - 0.5) / 0.2820948, 1e-5);
  EXPECT_NEAR(again.attribute(splat::kSh + 1)[0], 0.5 / 0.2820948, 1e-5);
  EXPECT_NEAR(again.attribute(splat::kSh + 2)[0], -0.5 / 0.2820948, 1e-5);
}

TEST_F(CompressedPly, WhatDoesNotFitIsRefusedAndTheOldFileStays) {
  WriteBytes(path_, "old");
  SplatModel model = RandomSplat(1, 5);
  model.attribute(splat::kSh)[1] = std::nanf("");
  EXPECT_THAT([&] { WriteCompressedPly(path_, model); }, ThrowsError(kBadArgument, path_, "1", "5"));
  model.Resize(1, 0);
  EXPECT_THAT([&] { WriteCompressedPly(path_, model); }, ThrowsError(kBadArgument, path_));
  EXPECT_EQ(ReadBytes(path_), "old");
  EXPECT_THAT([&] { WriteCompressedPly(folder_ / "none/a.ply", RandomSplat(0, 1)); },
              ThrowsError(kCannotWrite, "none/a.ply"));
}

TEST_F(CompressedPly, TakesAbsurdValues) {
  SplatModel model = RandomSplat(1, 600);
  model.attribute(splat::kMean)[0] = 3e38f;
  model.attribute(splat::kMean)[1] = -3e38f;
  model.attribute(splat::kLogScale)[2] = -1e30f;
  model.attribute(splat::kSh)[3] = 3e38f;
  model.attribute(splat::kSh + 3)[4] = -3e38f;
  model.attribute(splat::kQuaternion)[5] = 3e38f;
  WriteCompressedPly(path_, model);
  EXPECT_EQ(Read().count, 600);
}

// Damaged files give a one-line error, without a crash.
class CompressedPlyDamage : public CompressedPly {
 protected:
  CompressedPlyDamage() {
    WriteCompressedPly(path_, RandomSplat(1, 300));
    bytes_ = ReadBytes(path_);
  }
  void ExpectRefused(const std::string& bytes, const std::string& token = "") {
    WriteBytes(path_, bytes);
    EXPECT_THAT([&] { Read(); }, ThrowsError(kBadFile, path_, token));
  }
  std::string bytes_;
};

TEST_F(CompressedPlyDamage, PrefixesAreRefused) {
  for (std::size_t length = 0; length < bytes_.size(); length += length < 1000 ? 1 : 37) {
    ExpectRefused(bytes_.substr(0, length));
  }
}

TEST_F(CompressedPlyDamage, OverwrittenBytesLoadOrAreRefused) {
  const auto read = [&](const std::string& damaged) {
    WriteBytes(path_, damaged + bytes_.substr(1400));
    Read();
  };
  EXPECT_GT(CountRefusedCopies(bytes_.substr(0, 1400), 500, read), 0);
}

TEST_F(CompressedPlyDamage, MessagesNameWhatIsWrong) {
  for (const auto& [from, to, token] :
       std::vector<std::array<const char*, 3>>{{"chunk 2", "chunk 1", "256"},
                                               {"chunk 2", "chunk 2147483648", "2147483648"},
                                               {"chunk 2", "chunk two", "chunk"},
                                               {"vertex 300", "vertex 2147483648", "2147483648"},
                                               {"vertex 300", "vertex 0", ""},
                                               {"element vertex", "element corner", ""},
                                               {"sh 300", "sh 200", "200"},
                                               {"sh 300", "sh 301", "301"},
                                               {"min_scale_x", "min_scale_w", "min_scale_x"},
                                               {"max_g", "max_q", "max_g"},
                                               {"uint packed_color", "float packed_color", "packed_color"},
                                               {"packed_rotation", "packed_orientation", "packed_rotation"},
                                               {"uchar f_rest_3", "char f_rest_3", "f_rest_3"},
                                               {"f_rest_8", "g_rest_8", "8"},
                                               {"property float min_y", "property list uchar int min_y", "list"},
                                               {"element", "comment vesta origin 1 2 inf\nelement", "origin"},
                                               {"binary_little_endian", "ascii", ""}}) {
    ExpectRefused(Replaced(bytes_, from, to), token);
  }
  std::string damaged = bytes_;
  damaged.replace(damaged.find("end_header\n") + 11 + 8, 4, "\xff\xff\xff\x7f");
  ExpectRefused(damaged, "min_z");
  damaged.replace(damaged.find("end_header\n") + 11 + 8, 4, bytes_, bytes_.find("end_header\n") + 11 + 8, 4);
  damaged.replace(damaged.find("end_header\n") + 11 + 15 * 4, 4, "\xff\xff\x7f\x7f");
  WriteBytes(path_, damaged);
  const Index count = Read().count;
  EXPECT_TRUE(count > 0 && count < 300) << count << ": Gaussians whose colour is too large for float are left out";
}

std::vector<Index> Sorted(std::vector<Index> order) {
  std::sort(order.begin(), order.end());
  return order;
}

// Summed squared sides of each Gaussian's chunk's bounding box.
double Extents(const SplatModel& model, const std::vector<Index>& order, std::size_t chunk) {
  double sum = 0;
  for (std::size_t begin = 0; begin < order.size(); begin += chunk) {
    const std::size_t end = std::min(begin + chunk, order.size());
    for (int k = 0; k < 3; ++k) {
      double low = 1e300, high = -1e300;
      for (std::size_t i = begin; i < end; ++i) {
        low = std::min<double>(low, model.attribute(k)[order[i]]);
        high = std::max<double>(high, model.attribute(k)[order[i]]);
      }
      sum += static_cast<double>(end - begin) * (high - low) * (high - low);
    }
  }
  return sum;
}

TEST(ChunkOrder, HoldsEveryGaussianOnce) {
  for (const Index count : {0, 1, 7, 8, 9, 100, 5000}) {
    const SplatModel model = RandomSplat(0, count);
    std::vector<Index> all(static_cast<std::size_t>(count));
    std::iota(all.begin(), all.end(), Index{0});
    EXPECT_EQ(Sorted(ChunkOrder(model, 8)), all) << count;
  }
}

// A few Gaussians are far away, like a sky: chunks along a space-filling curve then span large gaps.
TEST(ChunkOrder, ChunksAreNarrowerThanThoseOfTheCurve) {
  SplatModel model = RandomSplat(0, 5000);
  for (Index i = 0; i < model.count; i += 20) {
    for (int k = 0; k < 3; ++k) model.attribute(k)[i] *= 30;
  }
  EXPECT_LT(Extents(model, ChunkOrder(model, 64), 64), 0.7 * Extents(model, SpatialOrder(model), 64));
}

TEST(ChunkOrder, TakesWhatIsAllInOnePlace) {
  SplatModel model;
  model.Resize(0, 1000);
  EXPECT_EQ(Sorted(ChunkOrder(model, 10)).size(), 1000u);
  std::fill_n(model.attribute(0), 500, 3e38f);
  std::fill_n(model.attribute(1), 100, -3e38f);
  EXPECT_EQ(Sorted(ChunkOrder(model, 10)).size(), 1000u);
}

}  // namespace

}  // namespace vesta::gs
