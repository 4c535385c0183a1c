// SPDX-License-Identifier: Apache-2.0
// Splat files of any supported format, and comments in them with further data about a splat.
#pragma once

#include <string>
#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

struct ReadSplatOptions {
  // A Gaussian with a value that is not finite, or with a zero quaternion, cannot be drawn. By default, files with such
  // Gaussians are rejected. With this option, the Gaussians are removed; the others keep their order.
  bool drop_unusable = false;
};

// Applies the options to a model as it is in a file. Throws Error, in one line with the file, if unusable Gaussians may
// not be removed, or if no Gaussian is left.
void RemoveUnusableGaussians(const std::string& path, const ReadSplatOptions& options, SplatModel* model);

// Checks a model before it is written. Throws Error if it has unusable Gaussians, or if its number of values does not
// fit its degree and count.
void CheckDrawable(const std::string& path, const SplatModel& model);

// Reads a splat; its content, not its name, selects the format: .ply in the INRIA layout or compressed (ply.h,
// compressed_ply.h), or .spz (spz.h). Throws Error, in one line with the file and the problem.
SplatModel ReadSplat(const std::string& path, const ReadSplatOptions& options = {});

// Writes a splat; its extension selects the format: .compressed.ply, .ply or .spz, in upper or lower case. Written
// completely or not at all (kernels/core/files.h). Throws Error, in one line with the file, for another extension or a
// model that the format cannot represent.
void WriteSplat(const std::string& path, const SplatModel& model);
// Throws Error for an unknown extension.
void CheckSplatExtension(const std::string& path);

// Comment lines with further data about a splat, which other programs ignore:
// "vesta background R G B": the background colour in training;
// "vesta eps2d H": the 2D dilation in pixels^2 for rendering, unless it is the default;
// "vesta origin X Y Z": the world point that is the origin of the means, unless it is zero.
std::vector<std::string> SplatComments(const SplatModel& model);

// Sets background, eps2d and origin from the comments; other comments are ignored. Throws Error, in one line with the
// file, if numbers are missing or invalid.
void ReadSplatComments(const std::string& path, const std::vector<std::string>& comments, SplatModel* model);

}  // namespace vesta::gs
