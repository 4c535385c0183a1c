// Colour images in memory, and their files.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vesta::gs {

// Three planes (red, green, blue), each height rows of width values in 0..1, gamma-encoded as in the file.
// Takes 12 bytes a pixel: 200 images of 1,200 x 800 are 2.3 GB.
struct Image {
  int width = 0, height = 0;
  std::vector<float> rgb;

  Image() = default;
  Image(int w, int h) : width(w), height(h), rgb(3 * num_pixels()) {}
  std::size_t num_pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  bool empty() const { return rgb.empty(); }
  float* plane(int channel) { return rgb.data() + static_cast<std::size_t>(channel) * num_pixels(); }
  const float* plane(int channel) const { return rgb.data() + static_cast<std::size_t>(channel) * num_pixels(); }
};

struct ImageSize {
  int width = 0, height = 0;
};

// Reads a JPEG (grey or colour) or a PNG (any colour type, 8 or 16 bits), told apart by their first bytes, not by the
// name. Alpha is composited over `background`. EXIF orientation and embedded profiles are ignored, as COLMAP does.
// Throws Error naming the file when it is missing, neither format, a CMYK JPEG, cut short or damaged.
Image LoadImage(const std::string& path, const std::array<float, 3>& background = {0, 0, 0});

// Size of an image file, from its header.
ImageSize ReadImageSize(const std::string& path);

// 8-bit RGB PNG; values are clamped to 0..1 and rounded. Written whole or not at all (atomic_file.h).
void SavePng(const std::string& path, const Image& image);

// The 8-bit value of a colour: 255 times it, clamped to 0..255 and rounded; 0 for NaN.
std::uint8_t QuantizeColor(float value);

// Area averaging: each pixel of the result is the mean of the part of the image it covers, partly covered pixels by
// their share. 1 <= width <= image.width, the same for height.
Image ResizeArea(const Image& image, int width, int height);

// Size after downscaling by a whole factor: floor(width / factor) x floor(height / factor), at least 1 x 1.
ImageSize DownscaledSize(ImageSize size, int factor);

}  // namespace vesta::gs
