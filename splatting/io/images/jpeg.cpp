// SPDX-License-Identifier: Apache-2.0
// JPEG with libjpeg. It reports errors with longjmp, so functions that can fail hold no object with a destructor.
#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <cstdlib>

#include "kernels/core/check.h"
#include "splatting/io/images/image_codecs.h"

// jpeglib.h needs the above; the values in jerror.h depend on jpeglib.h.
// clang-format off
#include <jpeglib.h>
#include <jerror.h>
// clang-format on

namespace vesta::gs {

namespace {

// libjpeg's error handler: stores the message and returns to setjmp(jump).
struct JpegErrors {
  jpeg_error_mgr manager;  // first, so that libjpeg's pointer to it also points to JpegErrors
  std::jmp_buf jump;
  char message[JMSG_LENGTH_MAX];

  // The handler of jpeg_std_error, except that errors return.
  jpeg_error_mgr* Use() {
    jpeg_error_mgr* used = jpeg_std_error(&manager);
    used->error_exit = Leave;
    return used;
  }
  [[noreturn]] static void Leave(j_common_ptr info) {
    auto* errors = reinterpret_cast<JpegErrors*>(info->err);
    errors->manager.format_message(info, errors->message);
    std::longjmp(errors->jump, 1);
  }
};

// libjpeg only warns of lost data and fills the image with grey; training needs complete images.
void OnMessage(j_common_ptr info, int level) {
  if (level >= 0) return;
  switch (info->err->msg_code) {
    case JWRN_JPEG_EOF:
    case JWRN_HIT_MARKER:
    case JWRN_HUFF_BAD_CODE:
    case JWRN_MUST_RESYNC:
      JpegErrors::Leave(info);
    default:
      break;
  }
}

class Decoder {
 public:
  Decoder() {
    info_.err = errors_.Use();
    errors_.manager.emit_message = OnMessage;
  }
  ~Decoder() { jpeg_destroy_decompress(&info_); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  bool ReadHeader(std::string_view bytes) {
    if (setjmp(errors_.jump) != 0) return false;
    jpeg_create_decompress(&info_);
    jpeg_mem_src(&info_, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    jpeg_read_header(&info_, TRUE);
    return true;
  }
  // Rows of interleaved 8-bit RGB.
  bool ReadPixels(unsigned char* rgb) {
    if (setjmp(errors_.jump) != 0) return false;
    info_.out_color_space = JCS_RGB;
    jpeg_start_decompress(&info_);
    while (info_.output_scanline < info_.output_height) {
      JSAMPROW row = rgb + std::size_t{3} * info_.output_scanline * info_.output_width;
      jpeg_read_scanlines(&info_, &row, 1);
    }
    jpeg_finish_decompress(&info_);
    return true;
  }
  const jpeg_decompress_struct& info() const { return info_; }
  const char* message() const { return errors_.message; }

 private:
  jpeg_decompress_struct info_{};
  JpegErrors errors_{};
};

class Encoder {
 public:
  Encoder() { info_.err = errors_.Use(); }
  ~Encoder() {
    jpeg_destroy_compress(&info_);
    std::free(bytes_);  // libjpeg's allocation
  }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;

  // rgb: rows of interleaved 8-bit RGB.
  bool Encode(const unsigned char* rgb, int width, int height, int quality) {
    if (setjmp(errors_.jump) != 0) return false;
    jpeg_create_compress(&info_);
    jpeg_mem_dest(&info_, &bytes_, &size_);
    info_.image_width = static_cast<JDIMENSION>(width);
    info_.image_height = static_cast<JDIMENSION>(height);
    info_.input_components = 3;
    info_.in_color_space = JCS_RGB;
    jpeg_set_defaults(&info_);
    jpeg_set_quality(&info_, quality, TRUE);
    info_.optimize_coding = TRUE;
    jpeg_start_compress(&info_, TRUE);
    while (info_.next_scanline < info_.image_height) {
      auto* row = const_cast<unsigned char*>(rgb) + std::size_t{3} * info_.next_scanline * info_.image_width;
      jpeg_write_scanlines(&info_, &row, 1);
    }
    jpeg_finish_compress(&info_);
    return true;
  }
  std::string_view bytes() const { return {reinterpret_cast<const char*>(bytes_), size_}; }
  const char* message() const { return errors_.message; }

 private:
  jpeg_compress_struct info_{};
  JpegErrors errors_{};
  unsigned char* bytes_ = nullptr;
  unsigned long size_ = 0;
};

}  // namespace

InterleavedImage DecodeJpeg(const std::string& path, std::string_view bytes, bool size_only) {
  Decoder decoder;
  if (!decoder.ReadHeader(bytes)) FailDamagedImage(path, decoder.message());
  if (decoder.info().num_components == 4) {
    Fail(kUnsupported,
         "{}: a CMYK JPEG; convert it to RGB, for instance with ImageMagick: convert in.jpg -colorspace sRGB out.jpg",
         path);
  }
  InterleavedImage image;
  image.size = {static_cast<int>(decoder.info().image_width), static_cast<int>(decoder.info().image_height)};
  CheckImageSize(path, bytes.size(), image.size);
  if (size_only) return image;
  image.Allocate();
  if (!decoder.ReadPixels(image.bytes.data())) FailDamagedImage(path, decoder.message());
  return image;
}

std::string EncodeJpeg(const Image& image, int quality) {
  VESTA_CHECK(image.width > 0 && image.height > 0, "image without pixels cannot be written as JPEG");
  const std::vector<std::uint8_t> rgb = InterleavedBytes(image);
  Encoder encoder;
  if (!encoder.Encode(rgb.data(), image.width, image.height, quality)) {
    Fail(kCannotWrite, "an image of {} x {} cannot be encoded as JPEG: {}", image.width, image.height,
         encoder.message());
  }
  return std::string(encoder.bytes());
}

}  // namespace vesta::gs
