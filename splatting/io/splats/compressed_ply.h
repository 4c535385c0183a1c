// SPDX-License-Identifier: Apache-2.0
// Splats in compressed .ply files: the format of PlayCanvas and SuperSplat (developer.playcanvas.com, "Compressed
// PLY"), 16 to 61 bytes a Gaussian. Chunks of 256 Gaussians have bounds, between which the numbers of each Gaussian
// lie.
#pragma once

#include <string>
#include <vector>

#include "kernels/core/span.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/io/splats/ply_file.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::gs {

// Whether it has chunks.
bool IsCompressedPly(const PlyFile& file);

// With bounds of colours or, as older files, without: then colours are in 0..1. Comments give what else it states
// (SplatComments). Throws Error, one line with the file and what is wrong.
SplatModel ReadCompressedPly(const PlyFile& file, const ReadSplatOptions& options = {});

// Writes little-endian, whole or not at all (kernels/core/files.h), the Gaussians in an order in which those of a chunk
// are near each other (ChunkOrder). Steps of what is stored, of the bounds' distance in a chunk:
//   means, log-scales    1/2047 in x and z, 1/1023 in y; log-scales are clamped to -40..40
//   colours              1/255 (f_dc)
// and of the whole:
//   rotations            1/723 in the three smaller numbers of the quaternion
//   opacities            1/255 (packed_values.h)
//   SH beyond degree 0   1/32 in -4..4, clamped; half of an error is made up for in the next Gaussian
// Throws Error, one line with the file, where a value is not finite.
void WriteCompressedPly(const std::string& path, const SplatModel& model);

// An order in which the bounds of each `chunk` of Gaussians in turn (the last may be shorter) are narrow: old indices
// in their new order. The means are finite. A curve through space leaves chunks where it leaps; here the Gaussians are
// parted by planes across an axis, again and again, each where the squares of the bounds' sides, summed over Gaussians,
// become least: on a trained scene 0.07 dB of PSNR (docs/decisions/compact-formats.md).
std::vector<Index> ChunkOrder(const SplatModel& model, Index chunk);

}  // namespace vesta::gs
