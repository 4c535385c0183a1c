// SPDX-License-Identifier: Apache-2.0
// What holds of every splat that has been read.
#pragma once

#include <string>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "tests/fuzz/promise.h"

namespace vesta::fuzz {

// Throws Finding unless it has Gaussians of a degree that there is, finite values, no zero quaternion, a background in
// 0..1 and a finite origin.
void PromiseSplat(const gs::SplatModel& model);

// Of a compact format: written to `copy` by `write` and read again by ReadSplat it has as many Gaussians, the same
// degree, background and origin. Or it is refused in one line that names the copy.
void PromiseItSurvives(const gs::SplatModel& model, const std::string& copy,
                       void (*write)(const std::string& path, const gs::SplatModel& model));

}  // namespace vesta::fuzz
