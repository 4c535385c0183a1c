// JPEG in, by libjpeg.
#include "kernels/core/check.h"
#include "splatting/io/images/image_codecs.h"
#include "splatting/io/images/jpeg_errors.h"

namespace vesta::gs {
namespace {

// libjpeg merely warns of lost data and fills the rest with grey: for training that is an error.
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
  // Rows of interleaved 8-bit RGB, one after the other.
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

}  // namespace

InterleavedImage DecodeJpeg(const std::string& path, std::string_view bytes, bool size_only) {
  Decoder decoder;
  if (!decoder.ReadHeader(bytes)) FailDamagedImage(path, decoder.message());
  if (decoder.info().num_components == 4) {
    Fail("{}: a CMYK JPEG; convert it to RGB, for instance with ImageMagick: convert in.jpg -colorspace sRGB out.jpg",
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

}  // namespace vesta::gs
