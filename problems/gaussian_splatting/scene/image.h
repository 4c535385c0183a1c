// SPDX-License-Identifier: Apache-2.0
// Colour images in memory, and colour scales.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::gs {

// A colour image: three planes (red, green, blue), each row by row, values in 0..1, gamma-encoded as in the file. Takes
// 12 bytes per pixel.
struct Image {
  int width = 0, height = 0;
  std::vector<float> rgb;
  // One byte per pixel: 0 excludes the pixel from the loss and the metrics. Empty: none.
  std::vector<std::uint8_t> mask;
  // For each pixel, the share of the background in its colour: 1 - alpha. Empty: none has any.
  std::vector<float> transparency;

  Image() = default;
  Image(int w, int h) : width(w), height(h), rgb(3 * num_pixels()) {}
  std::size_t num_pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  bool empty() const { return rgb.empty(); }
  float* plane(int channel) { return rgb.data() + static_cast<std::size_t>(channel) * num_pixels(); }
  const float* plane(int channel) const { return rgb.data() + static_cast<std::size_t>(channel) * num_pixels(); }
};

// Number of pixels that the mask includes, and their fraction.
std::size_t UnmaskedPixels(const Image& image);
double UnmaskedFraction(const Image& image);

// Pixel values, mask and transparency, bytes.
double BytesOf(const Image& image);

// Bytes per pixel, without mask.
inline constexpr double kImageBytes = 3 * sizeof(float);

struct ImageSize {
  int width = 0, height = 0;

  double pixels() const { return static_cast<double>(width) * height; }
};

// 255 times the value, clamped to 0..255 and rounded; 0 for NaN.
std::uint8_t QuantizeColor(float value);

// Shrinks an image to width x height: each pixel of the result is the mean of the image area that it covers. The mask
// excludes a pixel that covers an excluded one. 1 <= width <= image.width, the same for height.
Image ResizeArea(const Image& image, int width, int height);

// floor(width / factor) x floor(height / factor), at least 1 x 1.
ImageSize DownscaledSize(ImageSize size, int factor);

// Colour at position `of`, 0..1, interpolated between N equidistant colours (r, g, b).
template <std::size_t N>
std::array<float, 3> OnScale(const std::array<std::array<float, 3>, N>& colors, float of) {
  const float at = of * static_cast<float>(N - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(at), N - 2);
  std::array<float, 3> color;
  for (std::size_t c = 0; c < 3; ++c) {
    color[c] = std::lerp(colors[below][c], colors[below + 1][c], at - static_cast<float>(below));
  }
  return color;
}

// Violet, teal, yellow, with increasing lightness.
inline constexpr std::array<std::array<float, 3>, 5> kVioletToYellow = {{{0.20f, 0.05f, 0.30f},
                                                                         {0.22f, 0.25f, 0.58f},
                                                                         {0.10f, 0.52f, 0.58f},
                                                                         {0.40f, 0.76f, 0.38f},
                                                                         {0.99f, 0.92f, 0.30f}}};

}  // namespace vesta::gs
