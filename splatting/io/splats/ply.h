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

// The layout of the INRIA code (Kerbl et al. 2023): x y z nx ny nz f_dc_0..2 f_rest_0.. opacity scale_0..2 rot_0..3,
// f_rest channel by channel. Read in any order, float or double, binary or ascii, other properties ignored; the number
// of f_rest (0, 9, 24, 45) gives the degree. Comments give what else it states (SplatComments). An opacity logit
// may be infinite. Throws Error, one line with the file and what is wrong.
SplatModel ReadSplatPly(const std::string& path, const ReadSplatOptions& options = {});
SplatModel ReadSplatPly(const PlyFile& file, const ReadSplatOptions& options);

// Writes that layout, little-endian float, whole or not at all (kernels/core/files.h); reading it back gives the same
// bits.
void WriteSplatPly(const std::string& path, const SplatModel& model);
// The same into a file that is open, and stays so.
void WriteSplatPly(AtomicFile& file, const SplatModel& model);
// About how long it is of so many Gaussians, bytes; not more.
std::int64_t SplatPlyBytes(Index gaussians, int sh_degree);

// x y z, and red green blue (8 or 16 bits, or float in 0..1); mid-grey without colours. Throws Error where a point is
// not finite or there is none.
WorldPoints ReadPointPly(const std::string& path);

}  // namespace vesta::gs
