// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/images/image_file.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "tests/splatting/io/test_images.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

TEST(Exif, TellsTheOrientationInBothByteOrders) {
  for (int orientation = 1; orientation <= 8; ++orientation) {
    for (const bool big_endian : {false, true}) {
      EXPECT_EQ(ExifOrientation(WithOrientation(ExampleJpeg(6, 4), orientation, big_endian)), orientation);
    }
  }
}

TEST(Exif, IsUprightWhereNothingIsSaid) {
  EXPECT_EQ(ExifOrientation(ExampleJpeg(6, 4)), 1);
  EXPECT_EQ(ExifOrientation(""), 1);
  EXPECT_EQ(ExifOrientation("\x89PNG"), 1);
  EXPECT_EQ(ExifOrientation(WithOrientation(ExampleJpeg(6, 4), 9)), 1);
  const std::string whole = WithOrientation(ExampleJpeg(6, 4), 6);
  for (std::size_t length = 0; length < 60; ++length) {
    const int orientation = ExifOrientation(whole.substr(0, length));
    EXPECT_TRUE(orientation == 1 || orientation == 6) << length;
  }
}

TEST(Exif, TellsCamerasApart) {
  const std::string jpeg = ExampleJpeg(6, 4);
  for (const bool big_endian : {false, true}) {
    const auto read = [&](const std::string& model, unsigned focal_length, bool has_position) {
      return ReadExifOrigin(WithCamera(jpeg, model, focal_length, has_position, big_endian));
    };
    const ExifOrigin origin = read("Phone 5", 26, true);
    EXPECT_NE(origin.camera.find("Phone 5"), std::string::npos);
    EXPECT_TRUE(origin.has_position);
    EXPECT_FALSE(read("Phone 5", 26, false).has_position);
    EXPECT_EQ(read("Phone 5", 26, false).camera, origin.camera);
    EXPECT_NE(read("Phone 5", 52, true).camera, origin.camera);
    EXPECT_NE(read("Phone 6", 26, true).camera, origin.camera);
  }
  for (const std::string& other : {jpeg, std::string(), WithOrientation(jpeg, 6)}) {
    EXPECT_EQ(ReadExifOrigin(other).camera, "");
    EXPECT_FALSE(ReadExifOrigin(other).has_position);
  }
}

// A damaged segment gives fewer values, and none that is longer than 64 bytes.
TEST(Exif, OfADamagedFileIsShort) {
  constexpr std::size_t kMost = 4 * 65;
  const std::string whole = WithCamera(ExampleJpeg(6, 4), std::string(500, 'm'), 26, true);
  EXPECT_LE(ReadExifOrigin(whole).camera.size(), kMost);
  for (std::size_t at = 0; at < 130; ++at) {
    EXPECT_LE(ReadExifOrigin(whole.substr(0, at)).camera.size(), kMost);
    std::string damaged = whole;
    damaged[at] = '\xff';
    EXPECT_LE(ReadExifOrigin(damaged).camera.size(), kMost);
  }
}

// Input image:
// a b c
// d e f
TEST(Exif, TurnsUpright) {
  Image image(3, 2);
  for (std::size_t i = 0; i < 6; ++i) image.plane(1)[i] = static_cast<float>(i);
  const auto turned = [&](int orientation) {
    const Image upright = RotatedUpright(image, orientation);
    EXPECT_EQ(upright.width, orientation < 5 ? 3 : 2);
    std::string letters;
    for (std::size_t i = 0; i < 6; ++i) letters += static_cast<char>('a' + static_cast<int>(upright.plane(1)[i]));
    return letters;
  };
  EXPECT_EQ(turned(1), "abcdef");
  EXPECT_EQ(turned(3), "abcdef") << "orientations without swapped sides are ignored";
  EXPECT_EQ(turned(5), "adbecf");
  EXPECT_EQ(turned(6), "daebfc") << "90 degrees clockwise";
  EXPECT_EQ(turned(7), "fcebda");
  EXPECT_EQ(turned(8), "cfbead") << "90 degrees counterclockwise";
}

TEST(GrayPng, HoldsEveryLevelAndTheComment) {
  const TempFolder folder;
  const std::string path = folder / "depth.png";
  std::vector<std::uint16_t> values(256 * 256);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::uint16_t>(i);
  SaveGrayPng(path, {256, 256}, values, "what the levels mean");
  const Image image = LoadImage(path);
  ASSERT_EQ(image.width, 256);
  for (std::size_t i = 0; i < values.size(); ++i) {
    ASSERT_EQ(image.plane(1)[i], static_cast<float>(values[i]) / 65535.0f) << i;
  }
  const std::string bytes = ReadBytes(path), chunk("tEXtComment\0what the levels mean", 32);
  EXPECT_NE(bytes.find(chunk), std::string::npos);
}

TEST(GrayPng, OtherNumbersOfValuesAreRefused) {
  const TempFolder folder;
  EXPECT_THAT([&] { SaveGrayPng(folder / "a.png", {2, 2}, {1, 2, 3}, ""); }, ThrowsError(kBadArgument, "3", "2"));
  EXPECT_THAT([&] { SaveGrayPng(folder / "none/a.png", {1, 1}, {1}, ""); }, ThrowsError(kCannotWrite, "none/a.png"));
}

}  // namespace

}  // namespace vesta::gs
