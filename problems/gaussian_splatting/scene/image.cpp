// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/scene/image.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"

namespace vesta::gs {
namespace {

// The source pixels under one pixel of the result, and their weights.
struct Cover {
  int first = 0;
  std::vector<float> shares;
};

std::vector<Cover> Covers(int source, int target) {
  std::vector<Cover> covers(static_cast<std::size_t>(target));
  for (int i = 0; i < target; ++i) {
    // In units of 1 / target source pixels all bounds are whole numbers: pixel s covers [s target, (s + 1) target).
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

std::vector<std::uint8_t> ResizeMask(const Image& image, const std::vector<Cover>& columns,
                                     const std::vector<Cover>& rows) {
  std::vector<std::uint8_t> mask;
  if (image.mask.empty()) return mask;
  mask.reserve(columns.size() * rows.size());
  for (const Cover& row : rows) {
    for (const Cover& column : columns) {
      bool counts = true;
      for (std::size_t y = 0; y < row.shares.size() && counts; ++y) {
        const auto first = image.mask.begin() + static_cast<std::ptrdiff_t>((static_cast<std::size_t>(row.first) + y) *
                                                                                static_cast<std::size_t>(image.width) +
                                                                            static_cast<std::size_t>(column.first));
        counts = std::all_of(first, first + std::ssize(column.shares), [](std::uint8_t m) { return m != 0; });
      }
      mask.push_back(counts ? 1 : 0);
    }
  }
  return mask;
}

}  // namespace

std::uint8_t QuantizeColor(float value) {
  // A NaN fails the comparison.
  return value > 0 ? static_cast<std::uint8_t>(std::lround(255.0f * std::min(value, 1.0f))) : std::uint8_t{0};
}

std::size_t UnmaskedPixels(const Image& image) {
  const auto left_out = std::ranges::count(image.mask, std::uint8_t{0});
  return image.num_pixels() - static_cast<std::size_t>(left_out);
}

double BytesOf(const Image& image) {
  return static_cast<double>(sizeof(float) * (image.rgb.size() + image.transparency.size()) + image.mask.size());
}

double UnmaskedFraction(const Image& image) {
  if (image.mask.empty()) return 1;
  return static_cast<double>(UnmaskedPixels(image)) / static_cast<double>(image.num_pixels());
}

Image ResizeArea(const Image& image, int width, int height) {
  VESTA_CHECK(width >= 1 && width <= image.width && height >= 1 && height <= image.height,
              "cannot shrink an image of {} x {} to {} x {}", image.width, image.height, width, height);
  const std::vector<Cover> columns = Covers(image.width, width), rows = Covers(image.height, height);
  Image result(width, height);
  std::vector<float> mean_row(static_cast<std::size_t>(image.width));
  const auto shrink = [&](const float* from, float* to) {
    for (int y = 0; y < height; ++y) {
      const Cover& row = rows[static_cast<std::size_t>(y)];
      std::fill(mean_row.begin(), mean_row.end(), 0.0f);
      for (std::size_t k = 0; k < row.shares.size(); ++k) {
        const float* source = from + (static_cast<std::size_t>(row.first) + k) * mean_row.size();
        for (std::size_t x = 0; x < mean_row.size(); ++x) mean_row[x] += row.shares[k] * source[x];
      }
      float* target = to + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
      for (int x = 0; x < width; ++x) {
        const Cover& column = columns[static_cast<std::size_t>(x)];
        float sum = 0;
        for (std::size_t k = 0; k < column.shares.size(); ++k) {
          sum += column.shares[k] * mean_row[static_cast<std::size_t>(column.first) + k];
        }
        target[x] = sum;
      }
    }
  };
  for (int c = 0; c < 3; ++c) shrink(image.plane(c), result.plane(c));
  if (!image.transparency.empty()) {
    result.transparency.resize(result.num_pixels());
    shrink(image.transparency.data(), result.transparency.data());
  }
  result.mask = ResizeMask(image, columns, rows);
  return result;
}

ImageSize DownscaledSize(ImageSize size, int factor) {
  VESTA_CHECK(factor >= 1, "downscale factor {} is not positive", factor);
  return {std::max(size.width / factor, 1), std::max(size.height / factor, 1)};
}

}  // namespace vesta::gs
