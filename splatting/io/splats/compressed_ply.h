// SPDX-License-Identifier: Apache-2.0
// Compressed .ply files: the format of PlayCanvas and SuperSplat (developer.playcanvas.com, "Compressed PLY"), with 16
// to 61 bytes per Gaussian. A chunk is a run of 256 Gaussians. Its values are quantised between its lower and upper
// bounds.
#pragma once

#include <string>
#include <vector>

#include "kernels/core/span.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/io/splats/ply_file.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::gs {

// True if the file has an element "chunk".
bool IsCompressedPly(const PlyFile& file);

// Reads a splat. Chunks may have bounds of the colours; in older files without them, colours are in 0..1. vesta's
// comments are read too (SplatComments). Throws Error, in one line with the file and the problem, if the file is
// damaged.
SplatModel ReadCompressedPly(const PlyFile& file, std::vector<std::string>* notes = nullptr);

// Writes a splat, completely or not at all (kernels/core/files.h). Reorders the Gaussians so that chunks have narrow
// bounds (ChunkOrder).
// Quantisation steps relative to the bounds of a chunk:
//   means, log-scales    1/2047 in x and z, 1/1023 in y; log-scales are clamped to -40..40
//   colours              1/255 (f_dc)
// Absolute quantisation steps:
//   rotations            1/723 in the three smaller numbers of the quaternion
//   opacities            1/255 (packed_values.h)
//   SH above degree 0    1/32 in -4..4, clamped; half of an error is compensated in the next Gaussian
// Throws Error, with the file, if a value is not finite.
void WriteCompressedPly(const std::string& path, const SplatModel& model);

// An order of the Gaussians, as indices in the model, in which each run of `chunk` Gaussians has narrow bounds of the
// means (the last run may be shorter). The means must be finite.
// The Gaussians are divided recursively in two by a plane perpendicular to an axis. The plane minimises the sum, over
// both parts, of the number of Gaussians times the squared diagonal of their bounding box. A space-filling curve is
// worse (docs/decisions/compact-formats.md), because chunks at its jumps have wide bounds.
std::vector<Index> ChunkOrder(const SplatModel& model, Index chunk);

}  // namespace vesta::gs
