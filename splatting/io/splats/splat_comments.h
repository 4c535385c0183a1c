// SPDX-License-Identifier: Apache-2.0
// What vesta tells of a splat besides its Gaussians, as lines of text that files can carry and other programs ignore:
// "vesta background R G B", the colour it was trained over, "vesta low_pass H", the filter it is to be rendered with
// where that is not the usual one (pixels^2), and "vesta origin X Y Z", the point of the world that the means are
// about.
#pragma once

#include <string>
#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

// One each for what the model states; none for one about the world's origin without a background and with the usual
// filter.
std::vector<std::string> SplatComments(const SplatModel& model);

// Sets background, filter and origin by the comments, of which others are ignored. Throws Error, one line with the
// file, where the numbers are not there or cannot be.
void ReadSplatComments(const std::string& path, const std::vector<std::string>& comments, SplatModel* model);

}  // namespace vesta::gs
