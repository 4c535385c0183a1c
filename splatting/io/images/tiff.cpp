// SPDX-License-Identifier: Apache-2.0
// Reads TIFF with libtiff.
#include <tiffio.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <vector>

#include "kernels/core/check.h"
#include "splatting/io/images/image_codecs.h"

namespace vesta::gs {
namespace {

// The bytes of the file for libtiff, and libtiff's first error message.
struct Source {
  std::string_view bytes;
  std::size_t at = 0;
  char message[256] = "";

  static Source& Of(void* handle) { return *static_cast<Source*>(handle); }
  static tmsize_t Read(thandle_t handle, void* out, tmsize_t size) {
    Source& source = Of(handle);
    // At the end, returns 0. (Not -1: libtiff 4.5 takes it for a count, and writes before its buffer.)
    if (size < 0 || source.at > source.bytes.size()) return 0;
    const std::size_t given = std::min(static_cast<std::size_t>(size), source.bytes.size() - source.at);
    if (given > 0) std::memcpy(out, source.bytes.data() + source.at, given);
    source.at += given;
    return static_cast<tmsize_t>(given);
  }
  static tmsize_t Write(thandle_t, void*, tmsize_t) { return -1; }
  static toff_t Seek(thandle_t handle, toff_t offset, int whence) {
    Source& source = Of(handle);
    const std::size_t from = whence == SEEK_SET ? 0 : whence == SEEK_CUR ? source.at : source.bytes.size();
    return source.at = from + static_cast<std::size_t>(offset);
  }
  static int Close(thandle_t) { return 0; }
  static toff_t Size(thandle_t handle) { return Of(handle).bytes.size(); }
  static int OnError(TIFF*, void* user, const char*, const char* format, va_list values) {
    Source& source = Of(user);
    if (source.message[0] == 0) std::vsnprintf(source.message, sizeof(source.message), format, values);
    return 1;
  }
  static int OnWarning(TIFF*, void*, const char*, const char*, va_list) { return 1; }
};

using Tiff = std::unique_ptr<TIFF, void (*)(TIFF*)>;

// Limit for one allocation, against damaged tags and sizes.
constexpr tmsize_t kMostBytes = 1 << 30;

Tiff Open(Source* source) {
  const std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)> options(TIFFOpenOptionsAlloc(),
                                                                             TIFFOpenOptionsFree);
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), kMostBytes);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), Source::OnError, source);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), Source::OnWarning, source);
  // m: no memory mapping, since the file is already in memory.
  return {TIFFClientOpenExt("", "rm", source, Source::Read, Source::Write, Source::Seek, Source::Close, Source::Size,
                            nullptr, nullptr, options.get()),
          TIFFClose};
}

template <class T>
T Tag(TIFF* tiff, ttag_t tag) {
  T value{};
  TIFFGetFieldDefaulted(tiff, tag, &value);
  return value;
}

Alpha AlphaOf(TIFF* tiff) {
  std::uint16_t extra = 0;
  const std::uint16_t* kinds = nullptr;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_EXTRASAMPLES, &extra, &kinds);
  if (extra == 0 || kinds == nullptr) return Alpha::kNone;
  if (kinds[0] == EXTRASAMPLE_ASSOCALPHA) return Alpha::kPremultiplied;
  return kinds[0] == EXTRASAMPLE_UNASSALPHA ? Alpha::kStraight : Alpha::kNone;
}

// The kind of the samples, without pixels; nullopt if unsupported.
std::optional<InterleavedImage> KindOf(TIFF* tiff) {
  // JPEG in a TIFF is decoded to RGB.
  if (Tag<std::uint16_t>(tiff, TIFFTAG_COMPRESSION) == COMPRESSION_JPEG) {
    TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
  }
  const auto photometric = Tag<std::uint16_t>(tiff, TIFFTAG_PHOTOMETRIC),
             bits = Tag<std::uint16_t>(tiff, TIFFTAG_BITSPERSAMPLE),
             format = Tag<std::uint16_t>(tiff, TIFFTAG_SAMPLEFORMAT);
  InterleavedImage image;
  image.samples = Tag<std::uint16_t>(tiff, TIFFTAG_SAMPLESPERPIXEL);
  image.sample_bytes = bits / 8u;
  image.alpha = AlphaOf(tiff);
  const bool is_jpeg = Tag<std::uint16_t>(tiff, TIFFTAG_COMPRESSION) == COMPRESSION_JPEG;
  const bool is_rgb = photometric == PHOTOMETRIC_RGB || (is_jpeg && photometric == PHOTOMETRIC_YCBCR);
  const std::size_t colors = is_rgb ? 3 : 1, most = 16;
  const bool is_known =
      (is_rgb || photometric == PHOTOMETRIC_MINISBLACK) && (bits == 8 || bits == 16) && format == SAMPLEFORMAT_UINT;
  const bool has_samples = image.samples >= colors + (image.alpha == Alpha::kNone ? 0 : 1) && image.samples <= most &&
                           image.colors() == colors;
  if (!is_known || !has_samples) return std::nullopt;
  return image;
}

// A part of the image in the file: a tile, or one row.
struct Block {
  ImageSize size;
  bool is_tile = false;
};

// Block by block, and plane by plane if planes are separate. Returns false if a block is missing.
bool ReadPixels(TIFF* tiff, const Block& block, InterleavedImage* image) {
  const bool is_separate = Tag<std::uint16_t>(tiff, TIFFTAG_PLANARCONFIG) == PLANARCONFIG_SEPARATE;
  const std::size_t planes = is_separate ? image->samples : 1;
  const std::size_t together = image->samples / planes * image->sample_bytes,
                    pixel = image->samples * image->sample_bytes;
  const std::size_t expected =
      static_cast<std::size_t>(block.size.width) * static_cast<std::size_t>(block.size.height) * together;
  if (static_cast<std::size_t>(block.is_tile ? TIFFTileSize(tiff) : TIFFScanlineSize(tiff)) != expected) return false;
  std::vector<unsigned char> buffer(expected);
  const auto [width, height] = image->size;
  for (std::size_t plane = 0; plane < planes; ++plane) {
    for (int top = 0; top < height; top += block.size.height) {
      for (int left = 0; left < width; left += block.size.width) {
        const auto x = static_cast<std::uint32_t>(left), y = static_cast<std::uint32_t>(top);
        const auto s = static_cast<std::uint16_t>(plane);
        const bool is_read = block.is_tile ? TIFFReadTile(tiff, buffer.data(), x, y, 0, s) >= 0
                                           : TIFFReadScanline(tiff, buffer.data(), y, s) == 1;
        if (!is_read) return false;
        for (int row = 0; row < std::min(block.size.height, height - top); ++row) {
          const unsigned char* from =
              buffer.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(block.size.width) * together;
          unsigned char* to = image->bytes.data() + static_cast<std::size_t>(top + row) * image->row_bytes() +
                              static_cast<std::size_t>(left) * pixel + plane * together;
          for (int column = 0; column < std::min(block.size.width, width - left);
               ++column, from += together, to += pixel) {
            std::memcpy(to, from, together);
          }
        }
      }
    }
  }
  return true;
}

}  // namespace

InterleavedImage DecodeTiff(const std::string& path, std::string_view bytes, bool size_only) {
  Source source{bytes};
  const Tiff tiff = Open(&source);
  const auto fail = [&] {
    FailDamagedImage(path, source.message[0] != 0 ? source.message : "its pixel data is incomplete");
  };
  if (tiff == nullptr) fail();
  // Sides above the range of int become negative and are rejected.
  const auto size_of = [&](ttag_t width, ttag_t height) {
    return ImageSize{static_cast<int>(Tag<std::uint32_t>(tiff.get(), width)),
                     static_cast<int>(Tag<std::uint32_t>(tiff.get(), height))};
  };
  const ImageSize size = size_of(TIFFTAG_IMAGEWIDTH, TIFFTAG_IMAGELENGTH);
  CheckImageSize(path, bytes.size(), size);
  std::optional<InterleavedImage> image = KindOf(tiff.get());
  if (!image) {
    Fail(kUnsupported,
         "{}: a TIFF whose samples are not grey or RGB of 8 or 16 bits; convert it, for instance with ImageMagick: "
         "convert in.tif -colorspace sRGB -depth 16 out.tif",
         path);
  }
  image->size = size;
  const auto check_bytes = [&](ImageSize part) {
    CheckImageSize(path, bytes.size(), part);
    const double all = static_cast<double>(part.width) * part.height * static_cast<double>(image->samples) *
                       static_cast<double>(image->sample_bytes);
    if (all > static_cast<double>(kMostBytes))
      Fail(kUnsupported, "{}: its pixels need more than 1 GiB; downscale it", path);
  };
  check_bytes(size);
  if (size_only) return *std::move(image);

  Block block{{size.width, 1}};
  if (TIFFIsTiled(tiff.get()) != 0) {
    block = {size_of(TIFFTAG_TILEWIDTH, TIFFTAG_TILELENGTH), true};
    check_bytes(block.size);
  }
  image->Allocate();
  if (!ReadPixels(tiff.get(), block, &*image)) fail();
  return *std::move(image);
}

}  // namespace vesta::gs
