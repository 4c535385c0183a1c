// SPDX-License-Identifier: Apache-2.0
// .splat files: the format of antimatter15's viewer (github.com/antimatter15/splat), 32 bytes per Gaussian, without a
// header and without SH bands above 0.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

// Reads a splat. A size of zero becomes a small one (packed_values.h). Throws Error, in one line with the file, if the
// number of bytes is not a positive multiple of 32.
SplatModel ReadAntimatterSplat(const std::string& path, std::string_view bytes, std::vector<std::string>* notes);

// Writes a splat, completely or not at all (kernels/core/files.h). Means and sizes are floats. Quantisation steps:
//   colours        1/255 in 0..1, clamped
//   opacities      1/255 (packed_values.h)
//   rotations      1/128 in the four numbers of the quaternion (error at most 0.016 radians)
// SH bands above 0 and vesta's comments (SplatComments) are not stored; notes, unless null, then receives a line.
// Throws Error, with the file, if a value is not finite.
void WriteAntimatterSplat(const std::string& path, const SplatModel& model, std::vector<std::string>* notes);

}  // namespace vesta::gs
