// PNG by libpng. Its errors leave by longjmp, so each stage that may fail is a function of its own that holds no
// object with a destructor.
#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <vector>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/io/image_codecs.h"

namespace vesta::gs {
namespace {

class Decoder {
 public:
  explicit Decoder(std::string_view bytes) : left_(bytes) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, OnError, OnWarning);
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
  }
  ~Decoder() { png_destroy_read_struct(&png_, &info_, nullptr); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  // Afterwards pixels are RGB or RGBA, 8 or 16 bits (big-endian) a channel.
  bool ReadHeader() {
    if (info_ == nullptr) return false;
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_read_fn(png_, this, OnRead);
    png_read_info(png_, info_);
    png_set_expand(png_);
    png_set_gray_to_rgb(png_);
    png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    return true;
  }
  bool ReadPixels(png_bytepp rows) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_image(png_, rows);
    png_read_end(png_, nullptr);
    return true;
  }
  ImageSize size() const {
    return {static_cast<int>(png_get_image_width(png_, info_)), static_cast<int>(png_get_image_height(png_, info_))};
  }
  std::size_t channels() const { return png_get_channels(png_, info_); }
  std::size_t bytes_per_channel() const { return png_get_bit_depth(png_, info_) / 8u; }
  std::size_t row_bytes() const { return png_get_rowbytes(png_, info_); }
  const char* message() const { return message_; }

 private:
  [[noreturn]] static void OnError(png_structp png, png_const_charp message) {
    auto* self = static_cast<Decoder*>(png_get_error_ptr(png));
    std::snprintf(self->message_, sizeof(self->message_), "%s", message);
    png_longjmp(png, 1);
  }
  static void OnWarning(png_structp, png_const_charp) {}
  static void OnRead(png_structp png, png_bytep out, std::size_t size) {
    auto* self = static_cast<Decoder*>(png_get_io_ptr(png));
    if (size > self->left_.size()) png_error(png, "the file ends early");
    std::memcpy(out, self->left_.data(), size);
    self->left_.remove_prefix(size);
  }

  std::string_view left_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  char message_[256] = "out of memory";
};

float ChannelValue(const unsigned char* bytes, std::size_t bytes_per_channel) {
  return bytes_per_channel == 1 ? static_cast<float>(bytes[0]) / 255.0f
                                : static_cast<float>(256 * bytes[0] + bytes[1]) / 65535.0f;
}

// Of RGBA pixels; empty where all are. At soft borders colours are mixed with what lies behind.
std::vector<std::uint8_t> OpaquePixels(const std::vector<unsigned char>& pixels, std::size_t pixel_bytes,
                                       std::size_t channel_bytes) {
  std::vector<std::uint8_t> mask(pixels.size() / pixel_bytes);
  for (std::size_t i = 0; i < mask.size(); ++i) {
    const unsigned char* alpha = pixels.data() + i * pixel_bytes + 3 * channel_bytes;
    mask[i] = ChannelValue(alpha, channel_bytes) == 1 ? 1 : 0;
  }
  if (std::find(mask.begin(), mask.end(), std::uint8_t{0}) == mask.end()) mask.clear();
  return mask;
}

}  // namespace

Image DecodePng(const std::string& path, std::string_view bytes, const std::array<float, 3>& background,
                bool size_only) {
  Decoder decoder(bytes);
  if (!decoder.ReadHeader()) FailDamagedImage(path, decoder.message());
  CheckImageSize(path, bytes.size(), decoder.size());
  Image image;
  image.width = decoder.size().width;
  image.height = decoder.size().height;
  if (size_only) return image;

  const std::size_t row_bytes = decoder.row_bytes();
  std::vector<unsigned char> pixels(row_bytes * static_cast<std::size_t>(image.height));
  std::vector<png_bytep> rows(static_cast<std::size_t>(image.height));
  for (std::size_t y = 0; y < rows.size(); ++y) rows[y] = pixels.data() + y * row_bytes;
  if (!decoder.ReadPixels(rows.data())) FailDamagedImage(path, decoder.message());

  const std::size_t channel_bytes = decoder.bytes_per_channel(), pixel_bytes = decoder.channels() * channel_bytes;
  const bool has_alpha = decoder.channels() == 4;
  image.rgb.resize(3 * image.num_pixels());
  for (int c = 0; c < 3; ++c) {
    float* plane = image.plane(c);
    const float behind = background[static_cast<std::size_t>(c)];
    for (std::size_t i = 0; i < image.num_pixels(); ++i) {
      const unsigned char* pixel = pixels.data() + i * pixel_bytes;
      const float color = ChannelValue(pixel + static_cast<std::size_t>(c) * channel_bytes, channel_bytes);
      const float alpha = has_alpha ? ChannelValue(pixel + 3 * channel_bytes, channel_bytes) : 1.0f;
      plane[i] = has_alpha ? alpha * color + (1.0f - alpha) * behind : color;
    }
  }
  if (has_alpha) image.mask = OpaquePixels(pixels, pixel_bytes, channel_bytes);
  return image;
}

}  // namespace vesta::gs
