// SPDX-License-Identifier: Apache-2.0
// PNG with libpng. It reports errors with longjmp, so steps that can fail hold no objects with destructors.
#include <png.h>

#include <bit>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <vector>

#include "kernels/core/check.h"
#include "splatting/io/images/image_codecs.h"

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

  // Sets up RGB or RGBA with 8 or 16 bits per channel.
  bool ReadHeader() {
    if (info_ == nullptr) return false;
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_read_fn(png_, this, OnRead);
    png_read_info(png_, info_);
    png_set_expand(png_);
    png_set_gray_to_rgb(png_);
    if constexpr (std::endian::native == std::endian::little) png_set_swap(png_);
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

}  // namespace

InterleavedImage DecodePng(const std::string& path, std::string_view bytes, bool size_only) {
  Decoder decoder(bytes);
  if (!decoder.ReadHeader()) FailDamagedImage(path, decoder.message());
  CheckImageSize(path, bytes.size(), decoder.size());
  InterleavedImage image;
  image.size = decoder.size();
  if (size_only) return image;

  image.samples = decoder.channels();
  image.sample_bytes = decoder.bytes_per_channel();
  image.alpha = image.samples == 4 ? Alpha::kStraight : Alpha::kNone;
  image.Allocate();
  std::vector<png_bytep> rows(static_cast<std::size_t>(image.size.height));
  for (std::size_t y = 0; y < rows.size(); ++y) rows[y] = image.bytes.data() + y * image.row_bytes();
  if (!decoder.ReadPixels(rows.data())) FailDamagedImage(path, decoder.message());
  return image;
}

}  // namespace vesta::gs
