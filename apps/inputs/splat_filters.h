// SPDX-License-Identifier: Apache-2.0
// What convert leaves out of a splat.
#pragma once

#include <string>

#include "apps/cli/flags.h"
#include "apps/cli/outputs.h"
#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::app {

// Throws UsageError where the flags of the filters are none or do not go together, before anything is read.
void CheckFilterFlags(const Flags& flags);

// The splat without what lies outside of --box, and then without what --clean takes for floaters; it may be as it was.
// `files`: of the run, which get those of --scene; `said` gets a line for each. Throws Error where nothing would be
// left.
gs::SplatModel Filtered(const Flags& flags, gs::SplatModel model, RunFiles* files, std::string* said);

}  // namespace vesta::app
