// Image files that cannot be used: each gives one line, none crashes.
#include <png.h>

#include "problems/gaussian_splatting/io/image.h"
#include "tests/problems/gaussian_splatting/io/test_images.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

std::string ExamplePng() {
  PngSource source{24, 18, PNG_COLOR_TYPE_RGBA, 8, false, {}};
  for (int i = 0; i < 24 * 18 * 4; ++i) source.bytes.push_back(static_cast<std::uint8_t>(i * i));
  return EncodePng(source);
}

class ImageDamage : public testing::TestWithParam<std::string (*)()> {};
INSTANTIATE_TEST_SUITE_P(All, ImageDamage,
                         testing::Values(
                             +[] { return ExampleJpeg(40, 30, false); }, +[] { return ExampleJpeg(40, 30, true); },
                             +[] { return ExamplePng(); }));

TEST_P(ImageDamage, EveryCutIsRefused) {
  const TempFolder folder;
  const std::string path = folder / "image.jpg", bytes = GetParam()();
  // A JPEG without its last two bytes, the end marker, has all of its pixels: libjpeg takes the end of the file for it.
  for (std::size_t length = 0; length + 12 < bytes.size(); length += 7) {
    WriteBytes(path, bytes.substr(0, length));
    const std::string message = ErrorOf([&] { LoadImage(path); });
    EXPECT_THAT(message, testing::HasSubstr(path + ": ")) << "cut to " << length << " of " << bytes.size();
  }
  WriteBytes(path, bytes);
  EXPECT_EQ(ErrorOf([&] { LoadImage(path); }), "");
}

TEST_P(ImageDamage, OverwrittenBytesLoadOrAreRefused) {
  const TempFolder folder;
  const std::string path = folder / "image.png", bytes = GetParam()();
  int refused = 0;
  ForDamagedCopies(bytes, 250, [&](const std::string& damaged) {
    WriteBytes(path, damaged);
    refused += ErrorOf([&] { LoadImage(path); }).empty() ? 0 : 1;
  });
  EXPECT_GT(refused, 0);
}

TEST(ImageDamageKinds, MessagesSayWhatIsWrong) {
  const TempFolder folder;
  const std::string path = folder / "image.jpg";
  const auto load = [&] { LoadImage(path); };
  ExpectError(load, "image.jpg: no such file");
  WriteBytes(path, "These are words, no pixels.");
  ExpectError(load, "image.jpg: not a JPEG or PNG image");
  WriteBytes(path, "");
  ExpectError(load, "image.jpg: not a JPEG or PNG image");
  WriteBytes(path, EncodeJpeg({8, 8, 4, false, std::vector<std::uint8_t>(8 * 8 * 4, 90)}));
  ExpectError(load, "image.jpg: a CMYK JPEG");
  const std::string jpeg = ExampleJpeg(64, 64);
  WriteBytes(path, jpeg.substr(0, jpeg.size() / 2));
  ExpectError(load, "image.jpg: cut short or damaged");
  const std::string png = ExamplePng();
  WriteBytes(path, png.substr(0, png.size() / 2));
  ExpectError(load, "image.jpg: cut short or damaged (the file ends early)");
}

TEST(ImageDamageKinds, AHeaderThatPromisesTooMuchAllocatesNothing) {
  const TempFolder folder;
  const std::string path = folder / "image.jpg";
  std::string jpeg = ExampleJpeg(16, 16);
  const std::size_t frame = jpeg.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  for (std::size_t k = 5; k < 9; ++k) jpeg[frame + k] = '\xff';  // 65535 x 65535
  WriteBytes(path, jpeg);
  ExpectError([&] { LoadImage(path); }, "image.jpg: ");
  for (std::size_t k : {5u, 7u}) jpeg[frame + k] = '\x20';  // 8447 x 8447
  WriteBytes(path, jpeg);
  ExpectError([&] { LoadImage(path); }, "too short for the size in its header");
}

}  // namespace
}  // namespace vesta::gs
