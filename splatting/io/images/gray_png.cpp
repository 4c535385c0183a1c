// By libpng, whose errors leave by longjmp: the function that may fail holds no object with a destructor.
#include "splatting/io/images/gray_png.h"

#include <png.h>

#include <bit>
#include <csetjmp>
#include <cstdio>

#include "kernels/core/atomic_file.h"
#include "kernels/core/check.h"

namespace vesta::gs {
namespace {

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

}  // namespace

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
  if (!encoder.Encode(size, values.data(), &chunk)) Fail("{}: cannot be encoded as PNG: {}", path, encoder.message());
  WriteFileAtomically(path, encoder.bytes());
}

}  // namespace vesta::gs
