// SPDX-License-Identifier: Apache-2.0
// Splats in files of any known format; Gaussians that cannot be drawn are left out.
#pragma once

#include <string>

#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

// Gaussians that cannot be drawn: with a value that is not finite, or a quaternion of zero.

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

// Splats in files of any format that is known.

// By what the file holds, whatever its name: .ply in the INRIA layout or compressed (ply.h, compressed_ply.h), or .spz
// (spz.h). Throws Error, one line with the file and what is wrong.
SplatModel ReadSplat(const std::string& path, const ReadSplatOptions& options = {});

// By the extension, in letters of either case: .compressed.ply, .ply or .spz; whole or not at all (atomic_file.h).
// Throws Error, one line with the file: another extension, or a model that the format has no numbers for.
void WriteSplat(const std::string& path, const SplatModel& model);
// Throws that of another extension.
void CheckSplatExtension(const std::string& path);

}  // namespace vesta::gs
