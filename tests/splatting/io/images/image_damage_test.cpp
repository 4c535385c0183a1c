// SPDX-License-Identifier: Apache-2.0
// Damaged image files give a one-line error, without a crash.
#include <png.h>
#include <tiff.h>

#include "splatting/io/images/image_file.h"
#include "tests/splatting/io/test_images.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

std::string ExamplePng() {
  PngSource source{24, 18, PNG_COLOR_TYPE_RGBA, 8, false, {}};
  for (int i = 0; i < 24 * 18 * 4; ++i) source.bytes.push_back(static_cast<std::uint8_t>(i * i));
  return EncodePng(source);
}

std::vector<std::uint8_t> Bytes(std::size_t size) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(i * i));
  return bytes;
}

std::string ExampleTiff(int tile) {
  return EncodeTiff({.width = 24,
                     .height = 18,
                     .samples = 3,
                     .bits = 16,
                     .compression = COMPRESSION_LZW,
                     .tile = tile,
                     .bytes = Bytes(24 * 18 * 6)});
}

std::string ExampleWebp() { return EncodeWebp(24, 18, 4, Bytes(24 * 18 * 4)); }

class ImageDamage : public testing::TestWithParam<std::string (*)()> {};
INSTANTIATE_TEST_SUITE_P(All, ImageDamage,
                         testing::Values(
                             +[] { return ExampleJpeg(40, 30, false); }, +[] { return ExampleJpeg(40, 30, true); },
                             +[] { return ExamplePng(); }, +[] { return ExampleTiff(0); },
                             +[] { return ExampleTiff(16); }, +[] { return ExampleWebp(); }));

TEST_P(ImageDamage, EveryCutIsRefused) {
  const TempFolder folder;
  const std::string path = folder / "image.jpg", bytes = GetParam()();
  // libjpeg accepts a JPEG without its end marker (the last two bytes), which has all pixels.
  for (std::size_t length = 0; length + 12 < bytes.size(); length += 7) {
    WriteBytes(path, bytes.substr(0, length));
    EXPECT_THAT([&] { LoadImage(path); }, ThrowsError(kBadFile, path)) << "cut to " << length << " of " << bytes.size();
  }
  WriteBytes(path, bytes);
  EXPECT_NO_THROW(LoadImage(path));
}

TEST_P(ImageDamage, OverwrittenBytesLoadOrAreRefused) {
  const TempFolder folder;
  const std::string path = folder / "image.png", bytes = GetParam()();
  const auto load = [&](const std::string& damaged) {
    WriteBytes(path, damaged);
    LoadImage(path);
  };
  EXPECT_GT(CountRefusedCopies(bytes, 250, load), 0);
}

TEST(ImageDamageKinds, FilesThatAreNotReadAreNamed) {
  const TempFolder folder;
  const std::string path = folder / "image.jpg", jpeg = ExampleJpeg(64, 64), png = ExamplePng();
  EXPECT_THAT([&] { LoadImage(path); }, ThrowsError(kNotFound, path));
  for (const std::string& bad : {std::string("These are words, no pixels."), std::string(),
                                 jpeg.substr(0, jpeg.size() / 2), png.substr(0, png.size() / 2)}) {
    WriteBytes(path, bad);
    EXPECT_THAT([&] { LoadImage(path); }, ThrowsError(kBadFile, path));
  }
  WriteBytes(path, EncodeJpeg({8, 8, 4, false, std::vector<std::uint8_t>(8 * 8 * 4, 90)}));
  EXPECT_THAT([&] { LoadImage(path); }, ThrowsError(kUnsupported, path)) << "CMYK";
  for (const std::string& kind :
       {EncodeTiff({.width = 2, .height = 2, .bits = 32, .sample_format = SAMPLEFORMAT_IEEEFP, .bytes = Bytes(48)}),
        EncodeTiff({.width = 2, .height = 2, .samples = 4, .photometric = PHOTOMETRIC_SEPARATED, .bytes = Bytes(16)}),
        // An extended WebP header with the animation bit.
        std::string("RIFF\x12\0\0\0WEBPVP8X\x0a\0\0\0\x02\0\0\0\0\0\0\0\0\0", 30)}) {
    WriteBytes(path, kind);
    EXPECT_THAT([&] { LoadImage(path); }, ThrowsError(kUnsupported, path));
    EXPECT_THAT([&] { ReadImageSize(path); }, ThrowsError(kUnsupported, path));
  }
}

TEST(ImageDamageKinds, ATileBeyondTheFileAllocatesNothing) {
  const TempFolder folder;
  const std::string path = folder / "image";
  std::string tiff = ExampleTiff(16);
  // The entry of TIFFTAG_TILEWIDTH: tag 322, type, count 1, value.
  const std::size_t entry = tiff.find(std::string("\x42\x01\x03\0\x01\0\0\0", 8));
  ASSERT_NE(entry, std::string::npos);
  tiff[entry + 8] = '\xf0', tiff[entry + 9] = '\xff';
  const std::size_t length = tiff.find(std::string("\x43\x01\x03\0\x01\0\0\0", 8));
  ASSERT_NE(length, std::string::npos);
  tiff[length + 8] = '\xf0', tiff[length + 9] = '\xff';
  WriteBytes(path, tiff);
  EXPECT_THAT([&] { LoadImage(path); }, ThrowsError(kUnsupported, path, "65520"));
}

TEST(ImageDamageKinds, AHeaderThatPromisesTooMuchAllocatesNothing) {
  const TempFolder folder;
  const std::string path = folder / "image.jpg";
  std::string jpeg = ExampleJpeg(16, 16);
  const std::size_t frame = jpeg.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  for (std::size_t k = 5; k < 9; ++k) jpeg[frame + k] = '\xff';  // 65535 x 65535
  WriteBytes(path, jpeg);
  EXPECT_THAT([&] { LoadImage(path); }, ThrowsError(kBadFile, path));
  for (std::size_t k : {5u, 7u}) jpeg[frame + k] = '\x20';  // 8447 x 8447
  WriteBytes(path, jpeg);
  EXPECT_THAT([&] { LoadImage(path); }, ThrowsError(kBadFile, path));
}

}  // namespace
}  // namespace vesta::gs
