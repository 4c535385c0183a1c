// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/images/image_codecs.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace vesta::gs {
namespace {

template <class Sample>
float Value(const unsigned char* bytes, std::size_t index) {
  Sample sample;
  std::memcpy(&sample, bytes + index * sizeof(Sample), sizeof(Sample));
  return static_cast<float>(sample) / static_cast<float>(std::numeric_limits<Sample>::max());
}

template <class Sample>
Image PlanesOf(const InterleavedImage& source, const std::array<float, 3>& background) {
  Image image(source.size.width, source.size.height);
  const unsigned char* bytes = source.bytes.data();
  const std::size_t colors = source.colors(), samples = source.samples, pixels = image.num_pixels();
  const bool has_alpha = source.alpha != Alpha::kNone, is_straight = source.alpha == Alpha::kStraight;
  for (std::size_t c = 0; c < 3; ++c) {
    float* plane = image.plane(static_cast<int>(c));
    const std::size_t sample = colors == 3 ? c : 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      const float color = Value<Sample>(bytes, i * samples + sample);
      if (!has_alpha) {
        plane[i] = color;
        continue;
      }
      const float alpha = Value<Sample>(bytes, i * samples + colors);
      // A premultiplied colour cannot exceed its alpha, except in damaged files.
      const float shown = is_straight ? alpha * color : std::min(color, alpha);
      plane[i] = shown + (1.0f - alpha) * background[c];
    }
  }
  if (!has_alpha) return image;
  // At soft edges, colours are mixed with the background: only opaque pixels are used.
  image.mask.resize(pixels), image.transparency.resize(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    image.transparency[i] = 1 - Value<Sample>(bytes, i * samples + colors);
    image.mask[i] = image.transparency[i] == 0 ? 1 : 0;
  }
  if (std::ranges::find(image.mask, std::uint8_t{0}) == image.mask.end()) {
    image.mask = std::vector<std::uint8_t>(), image.transparency = std::vector<float>();
  }
  return image;
}

}  // namespace

Image ToPlanes(const InterleavedImage& source, const std::array<float, 3>& background) {
  return source.sample_bytes == 1 ? PlanesOf<std::uint8_t>(source, background)
                                  : PlanesOf<std::uint16_t>(source, background);
}

std::vector<std::uint8_t> InterleavedBytes(const Image& image) {
  const std::size_t pixels = image.num_pixels();
  std::vector<std::uint8_t> interleaved(3 * pixels);
  for (int c = 0; c < 3; ++c) {
    const float* plane = image.plane(c);
    for (std::size_t i = 0; i < pixels; ++i) interleaved[3 * i + static_cast<std::size_t>(c)] = QuantizeColor(plane[i]);
  }
  return interleaved;
}

}  // namespace vesta::gs
