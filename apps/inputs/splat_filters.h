// SPDX-License-Identifier: Apache-2.0
// The filters of convert: --box and --clean.
#pragma once

#include <string>

#include "apps/cli/flags.h"
#include "apps/cli/outputs.h"
#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::app {

// Throws UsageError if --box or the combination of flags is invalid. Reads no files.
void CheckFilterFlags(const Flags& flags);

// Removes the Gaussians outside --box and then, with --clean, the floaters. Adds the files of --scene to `files` and
// checks `files`. Appends one line for the user per filter to `message`. Throws Error if no Gaussian would remain.
gs::SplatModel Filtered(const Flags& flags, gs::SplatModel model, RunFiles* files, std::string* message);

}  // namespace vesta::app
