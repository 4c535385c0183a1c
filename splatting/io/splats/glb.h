// SPDX-License-Identifier: Apache-2.0
// .glb files: binary glTF 2.0 with the extension KHR_gaussian_splatting (ratified by Khronos in 2026;
// github.com/KhronosGroup/glTF, extensions/2.0/Khronos/KHR_gaussian_splatting). They are written, but not read.
#pragma once

#include <string>

#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

// Writes floats, completely or not at all (kernels/core/files.h). 60 to 240 bytes per Gaussian, in the given order:
//   POSITION           means. The axes are those of glTF: x left, y up, z forward, rotated by 180 degrees about z
//   ROTATION           unit quaternions x, y, z, w
//   SCALE              standard deviations, not their logarithms
//   OPACITY            0..1
//   SH_DEGREE_l_COEF_n all SH coefficients
//   COLOR_0            colour of degree 0 and opacity in bytes, for programs without the extension
// The colours are those of the photographs: sRGB. The comments (PlyComments) are in "extras" of the asset. Throws
// Error, with the file, if a value is not finite or the file would exceed 4 GiB.
void WriteGlb(const std::string& path, const SplatModel& model);

}  // namespace vesta::gs
