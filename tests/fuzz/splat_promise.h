// SPDX-License-Identifier: Apache-2.0
// The invariants of every splat that was read.
#pragma once

#include <string>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "tests/fuzz/promise.h"

namespace vesta::fuzz {

// Checks count, SH degree, finite values, nonzero quaternions, a background in 0..1 and a finite origin. Throws
// Finding.
void PromiseSplat(const gs::SplatModel& model);

// Writes the model in a compact format to `copy` with `write` and reads it with ReadSplat. Number of Gaussians, degree,
// background and origin must be equal, or the model is refused with one line that names `copy`.
void PromiseItSurvives(const gs::SplatModel& model, const std::string& copy,
                       void (*write)(const std::string& path, const gs::SplatModel& model));

}  // namespace vesta::fuzz
