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
// f_rest_0.. opacity scale_0..2 rot_0..3. f_rest has all coefficients of red, then green, then blue. Properties may
// have any order and type. Other properties are ignored. The number of f_rest properties (0, 9, 24 or 45) gives the SH
// degree. Without f_dc, the colours of a point cloud are used (ReadPointPly). Without scale_2, the Gaussians are disks,
// as in 2D Gaussian Splatting (Huang et al. 2024): their third scale is 1/1000 of the smaller of the others. vesta's
// comments are read too (SplatComments). An opacity logit may be infinite. Throws Error, in one line with the file and
// the problem, if the file is damaged or has another layout.
SplatModel ReadSplatPly(const std::string& path, std::vector<std::string>* notes = nullptr);
SplatModel ReadSplatPly(const PlyFile& file, std::vector<std::string>* notes);

// Writes the layout of ReadSplatPly in binary with floats, completely or not at all (kernels/core/files.h).
// ReadSplatPly gives the same bits.
void WriteSplatPly(const std::string& path, const SplatModel& model);
// Writes to an open file, which stays open.
void WriteSplatPly(AtomicFile& file, const SplatModel& model);
// Approximate bytes; not above the true size.
std::int64_t SplatPlyBytes(Index gaussians, int sh_degree);

// Reads a point cloud: properties x y z, and red green blue or diffuse_red diffuse_green diffuse_blue (8 or 16 bits, or
// float in 0..1). Points without colours become grey. Points that are not finite are left out, with a note. Throws
// Error if no point is left.
WorldPoints ReadPointPly(const std::string& path, std::vector<std::string>* notes = nullptr);

}  // namespace vesta::gs
