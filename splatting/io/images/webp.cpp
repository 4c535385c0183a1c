// SPDX-License-Identifier: Apache-2.0
// Reads WebP with libwebp, and writes it without loss.
#include <webp/decode.h>
#include <webp/encode.h>

#include <limits>

#include "kernels/core/check.h"
#include "splatting/io/images/image_codecs.h"

namespace vesta::gs {

InterleavedImage DecodeWebp(const std::string& path, std::string_view bytes, bool size_only) {
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(data, bytes.size(), &features) != VP8_STATUS_OK)
    FailDamagedImage(path, "its header is incomplete");
  if (features.has_animation != 0) Fail(kUnsupported, "{}: an animated WebP; save one frame as an image", path);
  InterleavedImage image;
  image.size = {features.width, features.height};
  // Without the check of the file size: a hundred bytes can be megapixels of one colour.
  CheckImageSize(path, std::numeric_limits<std::size_t>::max(), image.size);
  if (size_only) return image;

  const bool has_alpha = features.has_alpha != 0;
  image.samples = has_alpha ? 4 : 3;
  image.alpha = has_alpha ? Alpha::kStraight : Alpha::kNone;
  image.Allocate();
  const auto decode = has_alpha ? WebPDecodeRGBAInto : WebPDecodeRGBInto;
  if (decode(data, bytes.size(), image.bytes.data(), image.bytes.size(), static_cast<int>(image.row_bytes())) ==
      nullptr) {
    FailDamagedImage(path, "its pixels cannot be decoded");
  }
  return image;
}

std::string EncodeLosslessWebp(const std::string& path, const InterleavedImage& image) {
  constexpr int kEffort = 6;  // of 0 to 9; the default of libwebp
  WebPConfig config;
  WebPPicture picture;
  VESTA_CHECK(
      WebPConfigInit(&config) != 0 && WebPConfigLosslessPreset(&config, kEffort) != 0 && WebPPictureInit(&picture) != 0,
      "another version of libwebp was compiled with");
  config.exact = 1;
  picture.use_argb = 1;
  picture.width = image.size.width;
  picture.height = image.size.height;
  WebPMemoryWriter writer;
  WebPMemoryWriterInit(&writer);
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &writer;
  const bool is_written =
      WebPPictureImportRGBA(&picture, image.bytes.data(), static_cast<int>(image.row_bytes())) != 0 &&
      WebPEncode(&config, &picture) != 0;
  std::string bytes;
  if (is_written) bytes.assign(reinterpret_cast<const char*>(writer.mem), writer.size);
  WebPMemoryWriterClear(&writer);
  WebPPictureFree(&picture);
  if (!is_written) {
    Fail(kCannotWrite, "{}: libwebp cannot encode an image of {} x {} pixels (error {})", path, image.size.width,
         image.size.height, static_cast<int>(picture.error_code));
  }
  return bytes;
}

}  // namespace vesta::gs
