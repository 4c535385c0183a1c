// SPDX-License-Identifier: Apache-2.0
// Splat files of any supported format, and comment lines for vesta's further data.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/io/splats/spz_file.h"

namespace vesta::gs {

// Removes unusable Gaussians after reading: Gaussians with a value that is not finite, or with a zero quaternion. The
// others keep their order. If Gaussians are removed, adds a note with their number; notes may be null. Throws
// Error, in one line with the file, if no Gaussian is left.
void RemoveUnusableGaussians(const std::string& path, std::vector<std::string>* notes, SplatModel* model);

// Before writing: throws Error if the model has unusable Gaussians, or if its number of values does not fit its degree
// and count.
void CheckDrawable(const std::string& path, const SplatModel& model);

// Reads a splat. The content of the file, not its name, selects the format: .ply in the INRIA layout (ply.h),
// compressed .ply (compressed_ply.h), .spz (spz.h) or .sog (sog.h). .splat (antimatter_splat.h) and .ksplat (ksplat.h)
// have no magic number, so the extension selects them. Throws Error, in one line with the file and the problem, if the
// file cannot be read. For a file of another kind, this line lists the formats. notes, unless null, receives a line for
// the user if some Gaussians are left out (RemoveUnusableGaussians).
SplatModel ReadSplat(const std::string& path, std::vector<std::string>* notes = nullptr);

struct WriteSplatOptions {
  std::uint32_t spz_version = kLatestSpz;     // or kUniversalSpz (spz.h)
  std::vector<std::string>* notes = nullptr;  // receives a line for the user about each loss beyond rounding
};

// The extension of `path` selects the format: .compressed.ply, .ply, .spz, .splat, .sog or .glb, in upper or lower
// case. The file is written completely or not at all (kernels/core/files.h). Throws Error, with the file, for another
// extension, a model that the format cannot represent, or a file that cannot be written.
void WriteSplat(const std::string& path, const SplatModel& model, const WriteSplatOptions& options = {});
// Throws Error if WriteSplat does not support the extension of `path`.
void CheckSplatExtension(const std::string& path);

// Comment lines of a splat:
// "vesta background R G B": the background colour in training;
// "vesta eps2d H": the 2D dilation in pixels^2 for rendering, unless it is the default;
// "vesta origin X Y Z": the world point that is the origin of the means, unless it is zero.
std::vector<std::string> SplatComments(const SplatModel& model);
// The same for formats that have no flag for SplatModel::antialiased, with "SplatRenderMode: mip" if it is true.
std::vector<std::string> PlyComments(const SplatModel& model);

// Sets background, eps2d and origin from these lines, and antialiased if the line is there; ignores others. Throws
// Error, with the file, if numbers are missing or invalid.
void ReadSplatComments(const std::string& path, const std::vector<std::string>& comments, SplatModel* model);

}  // namespace vesta::gs
