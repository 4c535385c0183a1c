#include "problems/gaussian_splatting/io/image.h"

#include <png.h>

#include <algorithm>
#include <cmath>

#include "kernels/core/atomic_file.h"
#include "kernels/core/check.h"
#include "problems/gaussian_splatting/io/byte_reader.h"
#include "problems/gaussian_splatting/io/image_codecs.h"

namespace vesta::gs {

namespace {

Image Decode(const std::string& path, const std::array<float, 3>& background, bool size_only) {
  const std::string bytes = ReadFile(path);
  if (bytes.starts_with("\xff\xd8\xff")) return DecodeJpeg(path, bytes, size_only);
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return DecodePng(path, bytes, background, size_only);
  Fail("{}: not a JPEG or PNG image; convert it, or remove it from the scene", path);
}

// The source pixels under one pixel of the result, and the share of the result that each makes up.
struct Cover {
  int first = 0;
  std::vector<float> shares;
};

std::vector<Cover> Covers(int source, int target) {
  std::vector<Cover> covers(static_cast<std::size_t>(target));
  for (int i = 0; i < target; ++i) {
    // In units of 1 / target source pixels everything is whole: pixel s covers [s target, (s + 1) target).
    const Index begin = Index{i} * source, end = begin + source;
    Cover& cover = covers[static_cast<std::size_t>(i)];
    cover.first = static_cast<int>(begin / target);
    for (Index s = cover.first; s * target < end; ++s) {
      const Index overlap = std::min(end, (s + 1) * target) - std::max(begin, s * target);
      cover.shares.push_back(static_cast<float>(static_cast<double>(overlap) / source));
    }
  }
  return covers;
}

}  // namespace

Image LoadImage(const std::string& path, const std::array<float, 3>& background) {
  return Decode(path, background, false);
}

ImageSize ReadImageSize(const std::string& path) {
  const Image image = Decode(path, {}, true);
  return {image.width, image.height};
}

void CheckImageSize(const std::string& path, std::size_t num_bytes, ImageSize size) {
  constexpr double kMaxPixels = 1 << 28;
  // Deflate packs at most 1032 bytes into one, so 8256 black and white pixels; a JPEG needs more.
  constexpr double kMaxPixelsPerByte = 8320;
  const double pixels = static_cast<double>(size.width) * size.height;
  if (size.width <= 0 || size.height <= 0) FailDamagedImage(path, "it has no pixels");
  if (pixels > kMaxPixels) {
    Fail("{}: {} x {} pixels are more than the 268 million that are read; downscale it", path, size.width, size.height);
  }
  if (pixels > kMaxPixelsPerByte * static_cast<double>(num_bytes)) {
    FailDamagedImage(path, "it is too short for the size in its header");
  }
}

void FailDamagedImage(const std::string& path, const char* message) {
  Fail("{}: cut short or damaged ({}); copy or export it again", path, message);
}

std::uint8_t QuantizeColor(float value) {
  // Written so that NaN fails the first comparison.
  return value > 0 ? static_cast<std::uint8_t>(std::lround(255.0f * std::min(value, 1.0f))) : std::uint8_t{0};
}

void SavePng(const std::string& path, const Image& image) {
  VESTA_CHECK(image.width > 0 && image.height > 0, "{}: an image without pixels", path);
  const std::size_t pixels = image.num_pixels();
  std::vector<std::uint8_t> interleaved(3 * pixels);
  for (int c = 0; c < 3; ++c) {
    const float* plane = image.plane(c);
    for (std::size_t i = 0; i < pixels; ++i) interleaved[3 * i + static_cast<std::size_t>(c)] = QuantizeColor(plane[i]);
  }
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&png, bytes.data(), &size, 0, interleaved.data(), 0, nullptr) == 0) {
    Fail("{}: cannot be encoded as PNG: {}", path, png.message);
  }
  WriteFileAtomically(path, std::string_view(bytes).substr(0, size));
}

Image ResizeArea(const Image& image, int width, int height) {
  VESTA_CHECK(width >= 1 && width <= image.width && height >= 1 && height <= image.height,
              "cannot shrink {} x {} to {} x {}", image.width, image.height, width, height);
  const std::vector<Cover> columns = Covers(image.width, width), rows = Covers(image.height, height);
  Image result(width, height);
  std::vector<float> mean_row(static_cast<std::size_t>(image.width));
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < height; ++y) {
      const Cover& row = rows[static_cast<std::size_t>(y)];
      std::fill(mean_row.begin(), mean_row.end(), 0.0f);
      for (std::size_t k = 0; k < row.shares.size(); ++k) {
        const float* source = image.plane(c) + (static_cast<std::size_t>(row.first) + k) * mean_row.size();
        for (std::size_t x = 0; x < mean_row.size(); ++x) mean_row[x] += row.shares[k] * source[x];
      }
      float* target = result.plane(c) + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
      for (int x = 0; x < width; ++x) {
        const Cover& column = columns[static_cast<std::size_t>(x)];
        float sum = 0;
        for (std::size_t k = 0; k < column.shares.size(); ++k) {
          sum += column.shares[k] * mean_row[static_cast<std::size_t>(column.first) + k];
        }
        target[x] = sum;
      }
    }
  }
  return result;
}

ImageSize DownscaledSize(ImageSize size, int factor) {
  VESTA_CHECK(factor >= 1, "downscale factor {} is not positive", factor);
  return {std::max(size.width / factor, 1), std::max(size.height / factor, 1)};
}

}  // namespace vesta::gs
