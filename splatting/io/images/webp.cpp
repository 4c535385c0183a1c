// SPDX-License-Identifier: Apache-2.0
// Reads WebP with libwebp.
#include <webp/decode.h>

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

}  // namespace vesta::gs
