// SPDX-License-Identifier: Apache-2.0
// Splats in files of any known format, and the comments by which files tell more of a splat than its Gaussians.
#pragma once

#include <string>
#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

struct ReadSplatOptions {
  // A Gaussian with a value that is not finite, or with a zero quaternion, cannot be drawn. By default a file with such
  // is refused; with this set they are left out, the others keep their order.
  bool drop_unusable = false;
};

// Of a model as a file has it, does what the options say. Throws Error, one line with the file, where there are such
// Gaussians that may not be left out, or none is left.
void TakeUsableGaussians(const std::string& path, const ReadSplatOptions& options, SplatModel* model);

// Of a model to be written to the file. Throws Error where there are such Gaussians, or another number of values than
// the degree and count say.
void CheckDrawable(const std::string& path, const SplatModel& model);

// Reads a splat by what the file holds, whatever its name: .ply in the INRIA layout or compressed (ply.h,
// compressed_ply.h), or .spz (spz.h). Throws Error, one line with the file and what is wrong.
SplatModel ReadSplat(const std::string& path, const ReadSplatOptions& options = {});

// Writes a splat by the extension, in letters of either case: .compressed.ply, .ply or .spz; whole or not at all
// (kernels/core/files.h). Throws Error, one line with the file: another extension, or a model that the format has no
// numbers for.
void WriteSplat(const std::string& path, const SplatModel& model);
// Throws that of another extension.
void CheckSplatExtension(const std::string& path);

// What vesta tells of a splat besides its Gaussians, as lines of text that files can carry and other programs ignore:
// "vesta background R G B", the colour it was trained over, "vesta eps2d H", the filter it is to be rendered with
// where that is not the usual one (pixels^2), and "vesta origin X Y Z", the point of the world that the means are
// about.
// One each for what the model states; none for one about the world's origin without a background and with the usual
// filter.
std::vector<std::string> SplatComments(const SplatModel& model);

// Sets background, filter and origin by the comments, of which others are ignored. Throws Error, one line with the
// file, where the numbers are not there or cannot be.
void ReadSplatComments(const std::string& path, const std::vector<std::string>& comments, SplatModel* model);

}  // namespace vesta::gs
