// SPDX-License-Identifier: Apache-2.0
// .ksplat files: the format of Mark Kellogg's viewer (github.com/mkkellogg/GaussianSplats3D), 24 to 140 bytes per
// Gaussian, with SH degree 0 to 2. vesta reads them.
#pragma once

#include <string>
#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

// Reads a splat of format version 0.1, with any compression level (0, 1 or 2) and any sections. A size of zero becomes
// a small one (packed_values.h). Throws Error, in one line with the file and the problem, if the file is damaged or not
// supported. All counts are checked against the length of the file before memory is allocated.
SplatModel ReadKsplat(const std::string& path, std::string bytes, std::vector<std::string>* notes);

}  // namespace vesta::gs
