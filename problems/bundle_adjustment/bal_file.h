// SPDX-License-Identifier: Apache-2.0
// Text files of "Bundle adjustment in the large": a line `cameras points observations`, a line `camera point x y` for
// each observation, then the parameters, one a line (projection.h has their meaning).
#pragma once

#include <string>

#include "problems/bundle_adjustment/bundle_data.h"

namespace vesta {
class AtomicFile;
}

namespace vesta::bundle {

// Throws Error, one line that names the file and the line at fault: not such a file, cut short, indices out of range,
// counts that the file cannot hold, numbers that are not finite, something after the last parameter.
BundleData ReadBal(const std::string& path);

// Written whole or not at all; reads back bit for bit. Throws Error where the file cannot be written.
void WriteBal(const std::string& path, const BundleData& data);
// The same into a file that is open, and stays so.
void WriteBal(AtomicFile& file, const BundleData& data);

}  // namespace vesta::bundle
