// SPDX-License-Identifier: Apache-2.0
// Splats in compressed .ply files: the format of PlayCanvas and SuperSplat (developer.playcanvas.com, "Compressed PLY")
// with 16 to 61 bytes per Gaussian. Each chunk of 256 Gaussians stores bounds, and the values are quantised between
// them.
#pragma once

#include <string>
#include <vector>

#include "kernels/core/span.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/io/splats/ply_file.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::gs {

// Whether the file has chunks.
bool IsCompressedPly(const PlyFile& file);

// Reads files with bounds of colours, and older files without, whose colours are in 0..1. Comments are read too
// (SplatComments). Throws Error, in one line with the file and the problem.
SplatModel ReadCompressedPly(const PlyFile& file, const ReadSplatOptions& options = {});

// Writes little-endian, completely or not at all (kernels/core/files.h), in an order that keeps chunks compact
// (ChunkOrder).
// Quantisation steps relative to the bounds of a chunk:
//   means, log-scales    1/2047 in x and z, 1/1023 in y; log-scales are clamped to -40..40
//   colours              1/255 (f_dc)
// Absolute quantisation steps:
//   rotations            1/723 in the three smaller numbers of the quaternion
//   opacities            1/255 (packed_values.h)
//   SH above degree 0    1/32 in -4..4, clamped; half of an error is compensated in the next Gaussian
// Throws Error, in one line with the file, if a value is not finite.
void WriteCompressedPly(const std::string& path, const SplatModel& model);

// An order of the Gaussians in which each run of `chunk` Gaussians has narrow bounds (the last may be shorter). Returns
// old indices in the new order. The means must be finite.
// The Gaussians are divided recursively by planes across an axis, each where the squared sides of the bounds, summed
// over Gaussians, are smallest. A space-filling curve is worse, because chunks at its jumps have wide bounds: 0.07 dB
// of PSNR on a trained scene (docs/decisions/compact-formats.md).
std::vector<Index> ChunkOrder(const SplatModel& model, Index chunk);

}  // namespace vesta::gs
