// SPDX-License-Identifier: Apache-2.0
// Image files: photographs with their orientation, and 16-bit grey images.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "problems/gaussian_splatting/scene/image.h"

namespace vesta::gs {

// Reads a JPEG (grey or colour), a PNG (any colour type, 8 or 16 bits), a TIFF (grey or RGB, 8 or 16 bits, its first
// page) or a WebP, told apart by their first bytes, not by the name. 16 bits stay 16. Alpha is composited over
// `background`, and the mask has the pixels that are opaque. Orientation (ExifOrientation) and embedded profiles are
// ignored, as COLMAP does. Throws Error naming the file when it is missing, none of these, a CMYK JPEG, a TIFF of other
// samples, an animation, cut short or damaged. work_bytes: unless null, gets what was held beside the result.
Image LoadImage(const std::string& path, const std::array<float, 3>& background = {0, 0, 0},
                double* work_bytes = nullptr);

// Size of an image file, from its header.
ImageSize ReadImageSize(const std::string& path);

// The bytes of a JPEG; values are clamped to 0..1 and rounded. quality: 1 to 100, as libjpeg has it. Throws Error for
// an image without pixels, or with more than 65500 a side.
std::string EncodeJpeg(const Image& image, int quality);

// 8-bit RGB PNG; values are clamped to 0..1 and rounded. Written whole or not at all (kernels/core/files.h).
void SavePng(const std::string& path, const Image& image);

// A PNG of one channel of 16 bits, linear; values row by row. comment: one line of ASCII on what they mean, which the
// file carries (chunk tEXt, "Comment"). Written whole or not at all (kernels/core/files.h).
void SaveGrayPng(const std::string& path, ImageSize size, const std::vector<std::uint16_t>& values,
                 const std::string& comment);

// The orientation that a JPEG's EXIF states, 1 to 8: 1 upright, 3 by half a turn, 6 and 8 by a quarter, the others
// mirrored. 1 where there is none, or none that can be read. Source: CIPA DC-008 (EXIF 2.32), tag 274, in APP1.
int ExifOrientation(std::string_view jpeg);

// The image upright, of one stored in an orientation that swaps its sides (5 to 8); of another as it is.
Image TurnedUpright(const Image& image, int orientation);

}  // namespace vesta::gs
