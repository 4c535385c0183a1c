// SPDX-License-Identifier: Apache-2.0
// Splats and point clouds in .ply files.
#pragma once

#include <cstdint>
#include <string>

#include "problems/gaussian_splatting/model/scene_frame.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/io/splats/ply_file.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta {
class AtomicFile;
}

namespace vesta::gs {

// Reads a splat in the layout of the INRIA code (Kerbl et al. 2023), with the properties x y z nx ny nz f_dc_0..2
// f_rest_0.. opacity scale_0..2 rot_0..3, in any order, float or double, binary or ascii. f_rest has all coefficients
// of red, then green, then blue; their number (0, 9, 24 or 45) gives the SH degree. Other properties are ignored. Reads
// vesta's comments too (SplatComments). An opacity logit may be infinite. Throws Error, naming the file, if the file is
// damaged or has another layout.
SplatModel ReadSplatPly(const std::string& path, const ReadSplatOptions& options = {});
SplatModel ReadSplatPly(const PlyFile& file, const ReadSplatOptions& options);

// Writes that layout in binary with floats, completely or not at all (kernels/core/files.h). Reading gives the same
// bits.
void WriteSplatPly(const std::string& path, const SplatModel& model);
// Writes to an open file, which stays open.
void WriteSplatPly(AtomicFile& file, const SplatModel& model);
// Approximate bytes; not above the true size.
std::int64_t SplatPlyBytes(Index gaussians, int sh_degree);

// Properties x y z, and red green blue (8 or 16 bits, or float in 0..1). Points without colours become grey. Throws
// Error if a point is not finite, or if there are no points.
WorldPoints ReadPointPly(const std::string& path);

}  // namespace vesta::gs
