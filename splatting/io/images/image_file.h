// SPDX-License-Identifier: Apache-2.0
// Image files: photographs and 16-bit grey images.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "problems/gaussian_splatting/scene/image.h"

namespace vesta::gs {

// Reads a JPEG (grey or colour), a PNG (any colour type, 8 or 16 bits), a TIFF (grey or RGB, 8 or 16 bits, first page)
// or a WebP. The first bytes, not the name, determine the format. Samples of 16 bits keep their precision. Pixels that
// are not opaque are composited over `background` and masked; Image::transparency has their share of it. Orientation
// (ExifOrientation) and colour profiles are ignored, as in COLMAP. Throws Error naming the file if it is missing,
// damaged, truncated or unsupported (CMYK JPEG, other TIFF samples, animation). work_bytes: unless null, receives the
// bytes of the decoded samples. This memory is needed in addition to the result, until the samples are converted to the
// result.
Image LoadImage(const std::string& path, const std::array<float, 3>& background = {0, 0, 0},
                double* work_bytes = nullptr);

// Reads the header only. Throws Error like LoadImage.
ImageSize ReadImageSize(const std::string& path);

// Values are clamped to 0..1 and rounded. quality: 1 to 100, as in libjpeg. Throws Error for an image without pixels,
// or with a side above 65500.
std::string EncodeJpeg(const Image& image, int quality);

// Writes 8-bit RGB; values are clamped to 0..1 and rounded. Written completely or not at all (kernels/core/files.h).
void SavePng(const std::string& path, const Image& image);

// Writes 16-bit grey without gamma; values row by row. comment: one line of ASCII that explains the values (chunk tEXt,
// "Comment"). Written completely or not at all (kernels/core/files.h).
void SaveGrayPng(const std::string& path, ImageSize size, const std::vector<std::uint16_t>& values,
                 const std::string& comment);

// EXIF orientation of a JPEG, 1 to 8. 1: upright; 3: rotated by 180 degrees; 6 and 8: by 90 degrees; the others are
// mirrored. 1 if missing or unreadable. Source: CIPA DC-008 (EXIF 2.32), tag 274, in APP1.
int ExifOrientation(std::string_view jpeg);

struct ExifOrigin {
  std::string camera;         // bytes that are equal for photographs by one camera at one focal length
  bool has_position = false;  // has a GPS latitude
};
// From the EXIF data of a JPEG: make, model and focal lengths. The values are empty if missing or unreadable. Source:
// CIPA DC-008 (EXIF 2.32).
ExifOrigin ReadExifOrigin(std::string_view jpeg);

// Returns the upright image for orientations 5 to 8: exchanges width and height, and also undoes the mirroring of 5 and
// 7. Returns the image unchanged for orientations 1 to 4.
Image RotatedUpright(const Image& image, int orientation);

}  // namespace vesta::gs
