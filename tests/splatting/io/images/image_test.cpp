// SPDX-License-Identifier: Apache-2.0
#include <png.h>
#include <tiff.h>

#include <cmath>
#include <cstring>

#include "splatting/io/images/image_file.h"
#include "tests/splatting/io/test_images.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

Image LoadBytes(const std::string& bytes, const std::array<float, 3>& background = {0, 0, 0}) {
  const TempFolder folder;
  WriteBytes(folder / "image", bytes);
  const ImageSize size = ReadImageSize(folder / "image");
  Image image = LoadImage(folder / "image", background);
  EXPECT_EQ(size.width, image.width);
  EXPECT_EQ(size.height, image.height);
  EXPECT_EQ(image.rgb.size(), 3 * image.num_pixels());
  return image;
}

TEST(Png, KnownPixelsOfEveryKind) {
  // Images of 2 x 1 pixels.
  const Image rgb = LoadBytes(EncodePng({2, 1, PNG_COLOR_TYPE_RGB, 8, false, {255, 0, 51, 102, 153, 204}}));
  EXPECT_EQ(rgb.rgb, (std::vector<float>{1.0f, 0.4f, 0.0f, 0.6f, 0.2f, 0.8f}));
  const Image deep = LoadBytes(EncodePng({1, 1, PNG_COLOR_TYPE_RGB, 16, false, {0xff, 0xff, 0x33, 0x33, 0x00, 0x01}}));
  EXPECT_EQ(deep.rgb, (std::vector<float>{1.0f, 0.2f, 1.0f / 65535}));
  const Image grey = LoadBytes(EncodePng({2, 1, PNG_COLOR_TYPE_GRAY, 8, false, {51, 255}}));
  EXPECT_EQ(grey.rgb, (std::vector<float>{0.2f, 1.0f, 0.2f, 1.0f, 0.2f, 1.0f}));
  const Image bits = LoadBytes(EncodePng({2, 1, PNG_COLOR_TYPE_GRAY, 1, false, {0x40}}));
  EXPECT_EQ(bits.rgb, (std::vector<float>{0.0f, 1.0f, 0.0f, 1.0f, 0.0f, 1.0f}));
}

TEST(Png, AlphaIsCompositedOverTheBackground) {
  const std::array<float, 3> background{0.5f, 1.0f, 0.0f};
  const Image rgba =
      LoadBytes(EncodePng({2, 1, PNG_COLOR_TYPE_RGBA, 8, false, {255, 0, 255, 51, 9, 9, 9, 0}}), background);
  const std::vector<float> expected{0.2f + 0.8f * 0.5f, 0.5f, 0.8f, 1.0f, 0.2f, 0.0f};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(rgba.rgb[i], expected[i], 1e-6f);
  ASSERT_EQ(rgba.transparency.size(), 2u);
  EXPECT_NEAR(rgba.transparency[0], 0.8f, 1e-6f);
  EXPECT_EQ(rgba.transparency[1], 1.0f);
  const Image deep =
      LoadBytes(EncodePng({1, 1, PNG_COLOR_TYPE_GRAY_ALPHA, 16, false, {0xff, 0xff, 0x33, 0x33}}), background);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(deep.rgb[c], 0.2f + 0.8f * background[c], 1e-6f);
}

TEST(Png, PaletteWithTransparency) {
  const Image image = LoadBytes(EncodePng({3, 1, PNG_COLOR_TYPE_PALETTE, 8, false, {1, 0, 2}}), {1, 1, 1});
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(image.plane(c)[0], static_cast<float>(PaletteColors()[1][c]) / 255);
    EXPECT_EQ(image.plane(c)[1], static_cast<float>(PaletteColors()[0][c]) / 255);
    const float alpha = 128.0f / 255;
    EXPECT_NEAR(image.plane(c)[2], alpha * static_cast<float>(PaletteColors()[2][c]) / 255 + 1 - alpha, 1e-6f);
  }
}

TEST(Png, InterlacedIsTheSame) {
  PngSource source{7, 9, PNG_COLOR_TYPE_RGB, 8, false, {}};
  for (int i = 0; i < 7 * 9 * 3; ++i) source.bytes.push_back(static_cast<std::uint8_t>(37 * i));
  const Image plain = LoadBytes(EncodePng(source));
  source.interlaced = true;
  EXPECT_EQ(LoadBytes(EncodePng(source)).rgb, plain.rgb);
}

TEST(Png, RoundTripIsExactForEightBitValues) {
  const TempFolder folder;
  Image image(16, 16);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = static_cast<float>(i % 256) / 255.0f;
  SavePng(folder / "out.png", image);
  const Image again = LoadImage(folder / "out.png");
  EXPECT_EQ(again.width, 16);
  EXPECT_EQ(again.rgb, image.rgb);
  EXPECT_THAT([&] { SavePng(folder / "missing/out.png", image); }, ThrowsError(kCannotWrite, "missing/out.png"));
}

TEST(QuantizeColor, RoundsAndClamps) {
  EXPECT_EQ(QuantizeColor(-1.0f), 0);
  EXPECT_EQ(QuantizeColor(2.0f), 255);
  EXPECT_EQ(QuantizeColor(std::nanf("")), 0);
  EXPECT_EQ(QuantizeColor(100.49f / 255), 100);
  EXPECT_EQ(QuantizeColor(100.51f / 255), 101);
  for (int i = 0; i < 256; ++i) EXPECT_EQ(QuantizeColor(static_cast<float>(i) / 255.0f), i);
}

TEST(Jpeg, FlatColoursSurvive) {
  JpegSource source{20, 13, 3, false, {}};
  for (int i = 0; i < 20 * 13; ++i) source.bytes.insert(source.bytes.end(), {200, 100, 50});
  for (bool progressive : {false, true}) {
    source.progressive = progressive;
    const Image image = LoadBytes(EncodeJpeg(source));
    EXPECT_EQ(image.width, 20);
    EXPECT_EQ(image.height, 13);
    for (int c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < image.num_pixels(); ++i) {
        EXPECT_NEAR(image.plane(c)[i], static_cast<float>(source.bytes[static_cast<std::size_t>(c)]) / 255,
                    2.01f / 255);
      }
    }
  }
}

TEST(Jpeg, GreyGivesEqualPlanes) {
  JpegSource source{16, 8, 1, false, {}};
  for (int i = 0; i < 16 * 8; ++i) source.bytes.push_back(static_cast<std::uint8_t>(2 * i));
  const Image image = LoadBytes(EncodeJpeg(source));
  for (std::size_t i = 0; i < image.num_pixels(); ++i) {
    EXPECT_NEAR(image.plane(0)[i], static_cast<float>(2 * i) / 255, 3.01f / 255);
    EXPECT_EQ(image.plane(1)[i], image.plane(0)[i]);
    EXPECT_EQ(image.plane(2)[i], image.plane(0)[i]);
  }
}

std::vector<std::uint8_t> BytesOf(const std::vector<std::uint16_t>& values) {
  std::vector<std::uint8_t> bytes(2 * values.size());
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

TEST(Tiff, KnownPixelsOfEveryKind) {
  // Images of 2 x 1 pixels.
  const Image rgb = LoadBytes(EncodeTiff({.width = 2, .height = 1, .bytes = {255, 0, 51, 102, 153, 204}}));
  EXPECT_EQ(rgb.rgb, (std::vector<float>{1.0f, 0.4f, 0.0f, 0.6f, 0.2f, 0.8f}));
  const Image deep =
      LoadBytes(EncodeTiff({.width = 1, .height = 1, .bits = 16, .bytes = BytesOf({0xffff, 0x3333, 0x0001})}));
  EXPECT_EQ(deep.rgb, (std::vector<float>{1.0f, 0.2f, 1.0f / 65535}));
  const Image grey = LoadBytes(
      EncodeTiff({.width = 2, .height = 1, .samples = 1, .photometric = PHOTOMETRIC_MINISBLACK, .bytes = {51, 255}}));
  EXPECT_EQ(grey.rgb, (std::vector<float>{0.2f, 1.0f, 0.2f, 1.0f, 0.2f, 1.0f}));
}

TEST(Tiff, AlphaIsStraightPremultipliedOrNone) {
  const std::array<float, 3> background{0.5f, 1.0f, 0.0f};
  TiffSource source{.width = 2, .height = 1, .samples = 4, .bytes = {51, 0, 51, 51, 255, 255, 255, 255}};
  const auto first_pixel = [&](int kind) {
    source.extra_kind = kind;
    const Image image = LoadBytes(EncodeTiff(source), background);
    EXPECT_EQ(image.mask.empty(), kind == EXTRASAMPLE_UNSPECIFIED);
    return std::array<float, 3>{image.plane(0)[0], image.plane(1)[0], image.plane(2)[0]};
  };
  const std::array<float, 3> straight = first_pixel(EXTRASAMPLE_UNASSALPHA),
                             premultiplied = first_pixel(EXTRASAMPLE_ASSOCALPHA),
                             none = first_pixel(EXTRASAMPLE_UNSPECIFIED);
  for (std::size_t c = 0; c < 3; ++c) {
    const float color = c == 1 ? 0.0f : 0.2f;
    EXPECT_NEAR(straight[c], 0.2f * color + 0.8f * background[c], 1e-6f);
    EXPECT_NEAR(premultiplied[c], color + 0.8f * background[c], 1e-6f);
    EXPECT_EQ(none[c], color);
  }
}

// Strips and tiles, interleaved and separate planes, and all compressions.
TEST(Tiff, LayoutsAndCompressionsAreTheSame) {
  TiffSource source{.width = 37, .height = 21, .bits = 16, .bytes = {}};
  for (int i = 0; i < 37 * 21 * 6; ++i) source.bytes.push_back(static_cast<std::uint8_t>(37 * i));
  const Image plain = LoadBytes(EncodeTiff(source));
  for (const int compression : {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_PACKBITS}) {
    for (const int tile : {0, 16}) {
      for (const bool separate : {false, true}) {
        source.compression = compression, source.tile = tile, source.separate_planes = separate;
        EXPECT_EQ(LoadBytes(EncodeTiff(source)).rgb, plain.rgb) << compression << ' ' << tile << ' ' << separate;
      }
    }
  }
}

TEST(Tiff, JpegWithin) {
  TiffSource source{
      .width = 32, .height = 16, .compression = COMPRESSION_JPEG, .photometric = PHOTOMETRIC_YCBCR, .bytes = {}};
  for (int i = 0; i < 32 * 16; ++i) source.bytes.insert(source.bytes.end(), {200, 100, 50});
  const Image image = LoadBytes(EncodeTiff(source));
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(image.plane(c)[100], static_cast<float>(source.bytes[static_cast<std::size_t>(c)]) / 255, 4.01f / 255);
  }
}

TEST(Webp, KnownPixels) {
  const Image rgb = LoadBytes(EncodeWebp(2, 1, 3, {255, 0, 51, 102, 153, 204}));
  EXPECT_EQ(rgb.rgb, (std::vector<float>{1.0f, 0.4f, 0.0f, 0.6f, 0.2f, 0.8f}));
  EXPECT_TRUE(rgb.mask.empty());
  const Image rgba = LoadBytes(EncodeWebp(2, 1, 4, {255, 0, 255, 51, 9, 8, 7, 255}), {0.5f, 1.0f, 0.0f});
  EXPECT_NEAR(rgba.plane(0)[0], 0.2f + 0.8f * 0.5f, 1e-6f);
  EXPECT_NEAR(rgba.plane(1)[0], 0.8f, 1e-6f);
  EXPECT_EQ(rgba.mask, (std::vector<std::uint8_t>{0, 1}));
}

Image Ramp(int width, int height) {
  Image image(width, height);
  for (int c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < image.num_pixels(); ++i)
      image.plane(c)[i] = static_cast<float>((c + 1) * (i * i % 17)) / 64;
  }
  return image;
}

TEST(ResizeArea, WholeFactorsAreMeansOfBlocks) {
  const Image image = Ramp(6, 4), small = ResizeArea(image, 3, 2);
  for (int c = 0; c < 3; ++c) {
    for (std::size_t y = 0; y < 2; ++y) {
      for (std::size_t x = 0; x < 3; ++x) {
        const float* block = image.plane(c) + 2 * y * 6 + 2 * x;
        EXPECT_FLOAT_EQ(small.plane(c)[3 * y + x], (block[0] + block[1] + block[6] + block[7]) / 4);
      }
    }
  }
}

// 5 pixels to 2: each new pixel covers two and a half.
TEST(ResizeArea, PartlyCoveredPixelsCountByTheirShare) {
  Image image(5, 1);
  for (int c = 0; c < 3; ++c) {
    for (int x = 0; x < 5; ++x) image.plane(c)[x] = static_cast<float>(x * x);
  }
  const Image small = ResizeArea(image, 2, 1);
  for (int c = 0; c < 3; ++c) {
    EXPECT_FLOAT_EQ(small.plane(c)[0], (0 + 1 + 0.5f * 4) / 2.5f);
    EXPECT_FLOAT_EQ(small.plane(c)[1], (0.5f * 4 + 9 + 16) / 2.5f);
  }
}

TEST(ResizeArea, KeepsTheMeanAndTheImageItself) {
  const Image image = Ramp(13, 11), small = ResizeArea(image, 5, 3), same = ResizeArea(image, 13, 11);
  EXPECT_EQ(same.rgb, image.rgb);
  for (int c = 0; c < 3; ++c) {
    double before = 0, after = 0;
    for (std::size_t i = 0; i < image.num_pixels(); ++i)
      before += image.plane(c)[i] / static_cast<double>(image.num_pixels());
    for (std::size_t i = 0; i < small.num_pixels(); ++i)
      after += small.plane(c)[i] / static_cast<double>(small.num_pixels());
    EXPECT_NEAR(before, after, 1e-6);
  }
}

TEST(DownscaledSize, RoundsDownToAtLeastOnePixel) {
  EXPECT_EQ(DownscaledSize({101, 67}, 2).width, 50);
  EXPECT_EQ(DownscaledSize({101, 67}, 2).height, 33);
  EXPECT_EQ(DownscaledSize({101, 67}, 1).height, 67);
  EXPECT_EQ(DownscaledSize({101, 67}, 80).height, 1);
}

// A smooth image survives JPEG nearly unchanged; higher quality needs more bytes.
TEST(Jpeg, ComesBackAsItWasEncoded) {
  Image image(37, 21);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        image.plane(c)[y * image.width + x] = static_cast<float>(0.5 + 0.4 * std::sin(0.1 * x + 0.2 * y + c));
      }
    }
  }
  const std::string bytes = EncodeJpeg(image, 95);
  const Image decoded = LoadBytes(bytes);
  ASSERT_EQ(decoded.width, image.width);
  ASSERT_EQ(decoded.height, image.height);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) ASSERT_NEAR(decoded.rgb[i], image.rgb[i], 0.06) << i;
  EXPECT_LT(EncodeJpeg(image, 40).size(), bytes.size());
  EXPECT_THROW(EncodeJpeg(Image(), 90), Error);
  EXPECT_THROW(EncodeJpeg(Image(70000, 1), 90), Error) << "wider than the format allows";
}

}  // namespace
}  // namespace vesta::gs
