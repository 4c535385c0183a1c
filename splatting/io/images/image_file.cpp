// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/images/image_file.h"

#include <png.h>

#include <algorithm>
#include <bit>
#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "splatting/io/bytes/bytes.h"
#include "splatting/io/images/image_codecs.h"

namespace vesta::gs {
namespace {

using Decoder = InterleavedImage (*)(const std::string& path, std::string_view bytes, bool size_only);

// Compares the first bytes of the file; nullptr if unknown.
Decoder DecoderOf(std::string_view bytes) {
  using namespace std::string_view_literals;
  if (bytes.starts_with("\xff\xd8\xff")) return DecodeJpeg;
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return DecodePng;
  if (bytes.starts_with("RIFF") && bytes.substr(0, 12).ends_with("WEBP")) return DecodeWebp;
  for (const std::string_view tiff : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv}) {
    if (bytes.starts_with(tiff)) return DecodeTiff;
  }
  return nullptr;
}

InterleavedImage Decode(const std::string& path, bool size_only) {
  const std::string bytes = ReadFile(path);
  const Decoder decoder = DecoderOf(bytes);
  if (decoder == nullptr) {
    Fail(kBadFile, "{}: not a JPEG, PNG, TIFF or WebP image; convert it, or remove it from the scene", path);
  }
  return decoder(path, bytes, size_only);
}

// libpng reports errors with longjmp, so Encode holds no object with a destructor.
class Encoder {
 public:
  Encoder() {
    png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, this, OnError, OnWarning);
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
  }
  ~Encoder() { png_destroy_write_struct(&png_, &info_); }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;

  bool Encode(ImageSize size, const std::uint16_t* values, png_textp comment) {
    if (info_ == nullptr) return false;
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_write_fn(png_, this, OnWrite, OnFlush);
    const auto width = static_cast<png_uint_32>(size.width), height = static_cast<png_uint_32>(size.height);
    png_set_IHDR(png_, info_, width, height, 16, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_set_text(png_, info_, comment, 1);
    png_write_info(png_, info_);
    if (std::endian::native == std::endian::little) png_set_swap(png_);
    for (png_uint_32 y = 0; y < height; ++y) {
      png_write_row(png_, reinterpret_cast<png_const_bytep>(values + std::size_t{y} * width));
    }
    png_write_end(png_, nullptr);
    return true;
  }
  const std::string& bytes() const { return bytes_; }
  const char* message() const { return message_; }

 private:
  [[noreturn]] static void OnError(png_structp png, png_const_charp message) {
    auto* self = static_cast<Encoder*>(png_get_error_ptr(png));
    std::snprintf(self->message_, sizeof(self->message_), "%s", message);
    png_longjmp(png, 1);
  }
  static void OnWarning(png_structp, png_const_charp) {}
  static void OnWrite(png_structp png, png_bytep data, std::size_t size) {
    static_cast<Encoder*>(png_get_io_ptr(png))->bytes_.append(reinterpret_cast<const char*>(data), size);
  }
  static void OnFlush(png_structp) {}

  std::string bytes_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  char message_[256] = "out of memory";
};

// Reads numbers of 2 or 4 bytes in either byte order; 0 beyond the end.
struct Bytes {
  std::string_view bytes;
  bool big_endian = true;

  std::uint32_t Number(std::size_t at, std::size_t size) const {
    if (at > bytes.size() || size > bytes.size() - at) return 0;
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < size; ++k) {
      const std::size_t from = big_endian ? at + k : at + size - 1 - k;
      value = value << 8 | static_cast<unsigned char>(bytes[from]);
    }
    return value;
  }
};

// The TIFF structure in the EXIF segment of a JPEG; empty if there is no such segment.
std::string_view ExifOf(std::string_view jpeg) {
  using std::string_view_literals::operator""sv;
  constexpr auto kExif = "Exif\0\0"sv;
  constexpr std::uint32_t kApp1 = 0xffe1, kScan = 0xffda;
  if (!jpeg.starts_with("\xff\xd8")) return {};
  const Bytes in{jpeg};
  for (std::size_t at = 2; at + 4 <= jpeg.size();) {
    const std::uint32_t marker = in.Number(at, 2), length = in.Number(at + 2, 2);
    if (marker < 0xff00 || marker == kScan || length < 2) break;
    const std::string_view segment = jpeg.substr(at + 4, length - 2);
    if (marker == kApp1 && segment.starts_with(kExif)) return segment.substr(kExif.size());
    at += 2 + length;
  }
  return {};
}

// The directories of a TIFF structure. An entry has a tag, a type, a count, and a value or its offset.
class TiffEntries {
 public:
  explicit TiffEntries(std::string_view tiff)
      : in_{tiff, tiff.starts_with("MM")}, is_tiff_(tiff.starts_with("MM") || tiff.starts_with("II")) {}

  std::size_t first_directory() const { return in_.Number(4, 4); }
  // The offset of an entry; 0 if the directory does not have it.
  std::size_t Find(std::size_t directory, std::uint32_t tag) const {
    constexpr std::size_t kEntry = 12;
    const std::size_t count = is_tiff_ && directory != 0 ? in_.Number(directory, 2) : 0;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t entry = directory + 2 + k * kEntry;
      if (entry + kEntry > in_.bytes.size()) break;
      if (in_.Number(entry, 2) == tag) return entry;
    }
    return 0;
  }
  std::uint32_t Type(std::size_t entry) const { return in_.Number(entry + 2, 2); }
  std::uint32_t Whole(std::size_t entry, std::size_t size) const { return in_.Number(entry + kValue, size); }
  // At most 64 bytes of the value; empty if the entry is 0, or if its type is not one of the five below.
  std::string_view Value(std::size_t entry) const {
    constexpr std::size_t kTypeBytes[] = {0, 1, 1, 2, 4, 8}, kMost = 64;  // byte, text, short, long, rational
    if (entry == 0 || Type(entry) >= std::size(kTypeBytes)) return {};
    const std::size_t size = std::min<std::size_t>(in_.Number(entry + 4, 4), kMost) * kTypeBytes[Type(entry)];
    const std::size_t at = size <= 4 ? entry + kValue : Whole(entry, 4);
    return at < in_.bytes.size() ? in_.bytes.substr(at, std::min(size, kMost)) : std::string_view();
  }

 private:
  static constexpr std::size_t kValue = 8;
  Bytes in_;
  bool is_tiff_;
};

}  // namespace

Image LoadImage(const std::string& path, const std::array<float, 3>& background, double* work_bytes) {
  const InterleavedImage samples = Decode(path, false);
  if (work_bytes) *work_bytes = static_cast<double>(samples.bytes.size());
  return ToPlanes(samples, background);
}

ImageSize ReadImageSize(const std::string& path) { return Decode(path, true).size; }

void CheckImageSize(const std::string& path, std::size_t num_bytes, ImageSize size) {
  constexpr double kMaxPixels = 1 << 28;
  // Deflate compresses at most 1032 bytes into one, which is 8256 black-and-white pixels. JPEG compresses less.
  constexpr double kMaxPixelsPerByte = 8320;
  const double pixels = size.pixels();
  if (size.width <= 0 || size.height <= 0) FailDamagedImage(path, "it has no pixels");
  if (pixels > kMaxPixels) {
    Fail(kUnsupported, "{}: {} x {} pixels exceed the limit of 268 million; downscale it", path, size.width,
         size.height);
  }
  if (pixels > kMaxPixelsPerByte * static_cast<double>(num_bytes)) {
    FailDamagedImage(path, "it is too short for the size in its header");
  }
}

void FailDamagedImage(const std::string& path, const char* message) {
  Fail(kBadFile, "{}: truncated or damaged ({}); copy or export it again", path, message);
}

void SavePng(const std::string& path, const Image& image) {
  VESTA_CHECK(image.width > 0 && image.height > 0, "{}: image without pixels", path);
  const std::vector<std::uint8_t> interleaved = InterleavedBytes(image);
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&png, bytes.data(), &size, 0, interleaved.data(), 0, nullptr) == 0) {
    Fail(kCannotWrite, "{}: cannot be encoded as PNG: {}", path, png.message);
  }
  WriteFileAtomically(path, std::string_view(bytes).substr(0, size));
}

void SaveGrayPng(const std::string& path, ImageSize size, const std::vector<std::uint16_t>& values,
                 const std::string& comment) {
  VESTA_CHECK(size.width > 0 && size.height > 0 &&
                  values.size() == static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height),
              "{}: {} values for {} x {}", path, values.size(), size.width, size.height);
  std::string key = "Comment", text = comment;
  png_text chunk{};
  chunk.compression = PNG_TEXT_COMPRESSION_NONE;
  chunk.key = key.data();
  chunk.text = text.data();
  chunk.text_length = text.size();
  Encoder encoder;
  if (!encoder.Encode(size, values.data(), &chunk))
    Fail(kCannotWrite, "{}: cannot be encoded as PNG: {}", path, encoder.message());
  WriteFileAtomically(path, encoder.bytes());
}

int ExifOrientation(std::string_view jpeg) {
  constexpr std::uint32_t kOrientation = 274, kShort = 3;
  const TiffEntries exif(ExifOf(jpeg));
  const std::size_t entry = exif.Find(exif.first_directory(), kOrientation);
  if (entry == 0 || exif.Type(entry) != kShort) return 1;
  const std::uint32_t value = exif.Whole(entry, 2);
  return value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
}

ExifOrigin ReadExifOrigin(std::string_view jpeg) {
  constexpr std::uint32_t kMake = 271, kModel = 272, kDetails = 34665, kPosition = 34853, kLatitude = 2;
  constexpr std::uint32_t kFocalLength = 37386, kFocalLengthOn35mm = 41989;
  const TiffEntries exif(ExifOf(jpeg));
  const std::size_t first = exif.first_directory();
  const auto directory = [&](std::uint32_t tag) {
    const std::size_t entry = exif.Find(first, tag);
    return entry == 0 ? 0 : exif.Whole(entry, 4);
  };
  ExifOrigin origin;
  const auto add = [&](std::size_t entry) {
    if (const std::string_view value = exif.Value(entry); !value.empty()) origin.camera += std::string(value) + '\n';
  };
  for (const std::uint32_t tag : {kMake, kModel}) add(exif.Find(first, tag));
  for (const std::uint32_t tag : {kFocalLength, kFocalLengthOn35mm}) add(exif.Find(directory(kDetails), tag));
  origin.has_position = exif.Find(directory(kPosition), kLatitude) != 0;
  return origin;
}

Image RotatedUpright(const Image& image, int orientation) {
  constexpr int kFirstSwapped = 5;
  if (orientation < kFirstSwapped) return image;
  // Pixel (x, y) of the result is in row x or its opposite, and in column y or its opposite.
  const bool from_bottom = orientation == 6 || orientation == 7, from_right = orientation == 7 || orientation == 8;
  Image upright(image.height, image.width);
  for (int c = 0; c < 3; ++c) {
    const float* from = image.plane(c);
    float* to = upright.plane(c);
    for (int y = 0; y < upright.height; ++y) {
      const int column = from_right ? image.width - 1 - y : y;
      for (int x = 0; x < upright.width; ++x) {
        const int row = from_bottom ? image.height - 1 - x : x;
        *to++ = from[static_cast<std::ptrdiff_t>(row) * image.width + column];
      }
    }
  }
  return upright;
}

}  // namespace vesta::gs
