// Splats in files of any format that is known.
#pragma once

#include <string>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/io/splats/usable_gaussians.h"

namespace vesta::gs {

// By what the file holds, whatever its name: .ply in the INRIA layout or compressed (ply.h, compressed_ply.h), or .spz
// (spz.h). Throws Error, one line with the file and what is wrong.
SplatModel ReadSplat(const std::string& path, const ReadSplatOptions& options = {});

// By the extension, in letters of either case: .compressed.ply, .ply or .spz; whole or not at all (atomic_file.h).
// Throws Error, one line with the file: another extension, or a model that the format has no numbers for.
void WriteSplat(const std::string& path, const SplatModel& model);
// Throws that of another extension.
void CheckSplatExtension(const std::string& path);

}  // namespace vesta::gs
