// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/antimatter_splat.h"

#include <cmath>
#include <cstring>

#include "splatting/io/splats/splat_file.h"
#include "tests/splatting/io/random_splat.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

// Mean, standard deviations, colour with opacity, quaternion.
std::string SplatRow(std::array<float, 6> floats, std::array<std::uint8_t, 8> bytes) {
  std::string row(32, '\0');
  std::memcpy(row.data(), floats.data(), 24);
  std::memcpy(row.data() + 24, bytes.data(), 8);
  return row;
}

class AntimatterSplat : public testing::Test {
 protected:
  TempFolder folder_;
  std::string path_ = folder_ / "a.SPLAT";
};

TEST_F(AntimatterSplat, BytesAreTheFormats) {
  SplatModel model;
  model.Resize(0, 1);
  const float values[] = {1, -2, 3, 0, std::log(2.0f), -3, -2, 2, 0, 0, 0, 0, 9, -9};
  for (int a = 0; a < model.num_attributes(); ++a) model.attribute(a)[0] = values[a];
  WriteSplat(path_, model);
  // sqrt(1/2) 128 is 90.5.
  EXPECT_EQ(ReadBytes(path_),
            SplatRow({1, -2, 3, 1, std::exp(std::log(2.0f)), std::exp(-3.0f)}, {128, 255, 0, 128, 37, 219, 128, 128}));

  WriteBytes(path_, SplatRow({1, -2, 3, 1, 2, 0}, {255, 0, 51, 255, 128, 0, 128, 128}));
  model = ReadSplat(path_);
  EXPECT_EQ(model.attribute(splat::kMean + 2)[0], 3);
  EXPECT_EQ(model.attribute(splat::kLogScale)[0], 0);
  EXPECT_EQ(model.attribute(splat::kLogScale + 1)[0], std::log(2.0f));
  EXPECT_NEAR(model.attribute(splat::kLogScale + 2)[0], std::log(0x1p-25f), 1e-6);
  EXPECT_EQ(model.attribute(splat::kQuaternion)[0], 0);
  EXPECT_EQ(model.attribute(splat::kQuaternion + 1)[0], -1);
  EXPECT_NEAR(Opacity(model, 0), 1, 0.5 / 255);
  // The colour is 0.5 + 0.282 f_dc.
  for (const auto& [k, color] : {std::pair{0, 1.0}, {1, 0.0}, {2, 0.2}}) {
    EXPECT_NEAR(model.attribute(splat::kSh + k)[0], (color - 0.5) / 0.28209479, 1e-6);
  }
}

TEST_F(AntimatterSplat, RoundTripStaysWithinItsSteps) {
  SplatModel model = RandomSplat(0, 3000);
  for (int k = 0; k < 3; ++k) model.attribute(splat::kSh + k)[0] = k < 1 ? 1e30f : -1e30f;  // clamped
  WriteSplat(path_, model);
  const SplatModel again = ReadSplat(path_);
  ASSERT_EQ(again.count, model.count);
  EXPECT_NEAR(again.attribute(splat::kSh)[0], 0.5 / 0.28209479, 1e-6);
  EXPECT_NEAR(again.attribute(splat::kSh + 2)[0], -0.5 / 0.28209479, 1e-6);
  for (Index i = 0; i < model.count; ++i) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(again.attribute(splat::kMean + k)[i], model.attribute(splat::kMean + k)[i]);
      EXPECT_NEAR(again.attribute(splat::kLogScale + k)[i], model.attribute(splat::kLogScale + k)[i], 1e-5);
      const float dc = std::clamp(model.attribute(splat::kSh + k)[i], -1.772454f, 1.772454f);
      EXPECT_NEAR(again.attribute(splat::kSh + k)[i], dc, 0.5 / 255 / 0.28209479 + 1e-5);
    }
    EXPECT_NEAR(Opacity(again, i), Opacity(model, i), 0.5 / 255 + 1e-6);
    EXPECT_LE(AngleBetween(model, i, again, i), 0.016);
  }
}

TEST_F(AntimatterSplat, NotesNameTheLosses) {
  const auto notes_of = [&](const SplatModel& model) {
    std::vector<std::string> notes;
    WriteSplat(path_, model, {.notes = &notes});
    return notes;
  };
  SplatModel model = RandomSplat(2, 5);
  EXPECT_THAT(notes_of(model), testing::ElementsAre(testing::HasSubstr(path_)));
  EXPECT_EQ(ReadSplat(path_).sh_degree, 0);
  model.origin = {1, 2, 3};
  EXPECT_THAT(notes_of(model), testing::SizeIs(2));
  EXPECT_THAT(notes_of(RandomSplat(0, 5)), testing::IsEmpty());
  WriteSplat(path_, model);
  EXPECT_EQ(ReadSplat(path_).count, 5);
}

// The first bytes of a mean may be those of another format.
TEST_F(AntimatterSplat, MeansAreNoMagicNumbers) {
  const std::string row = SplatRow({1, 2, 3, 1, 1, 1}, {0, 0, 0, 255, 255, 128, 128, 128});
  for (const std::string& first : {std::string("ply\x3f"), std::string("\x1f\x8b\x08\x3f"), std::string("NGS\x3f")}) {
    WriteBytes(path_, first + row.substr(4));
    EXPECT_EQ(ReadSplat(path_).count, 1) << first;
  }
}

TEST_F(AntimatterSplat, BadFilesAreRefused) {
  const std::string row = SplatRow({1, 2, 3, 1, 1, 1}, {0, 0, 0, 255, 255, 128, 128, 128});
  for (const std::size_t bytes : {0u, 1u, 31u, 33u, 63u}) {
    WriteBytes(path_, (row + row).substr(0, bytes));
    EXPECT_THAT([&] { ReadSplat(path_); }, ThrowsError(kBadFile, path_, std::to_string(bytes), "32"));
  }
  const std::string zero = SplatRow({1, 2, 3, 1, 1, 1}, {0, 0, 0, 255, 128, 128, 128, 128}),
                    negative = SplatRow({1, 2, 3, 1, -1, 1}, {0, 0, 0, 255, 255, 128, 128, 128}),
                    infinite = SplatRow({1, 2, HUGE_VALF, 1, 1, 1}, {0, 0, 0, 255, 255, 128, 128, 128});
  WriteBytes(path_, zero + row + negative + infinite);
  std::vector<std::string> notes;
  EXPECT_EQ(ReadSplat(path_, &notes).count, 1);
  EXPECT_THAT(notes, testing::ElementsAre(testing::HasSubstr("3 of 4")));
  WriteBytes(path_, zero + infinite);
  EXPECT_THAT([&] { ReadSplat(path_); }, ThrowsError(kBadFile, path_, "2"));

  SplatModel model = RandomSplat(0, 2);
  model.attribute(splat::kMean)[1] = HUGE_VALF;
  EXPECT_THAT([&] { WriteSplat(path_, model); }, ThrowsError(kBadArgument, path_));
  model.Resize(0, 0);
  EXPECT_THAT([&] { WriteSplat(path_, model); }, ThrowsError(kBadArgument, path_));
}

}  // namespace
}  // namespace vesta::gs
