// SPDX-License-Identifier: Apache-2.0
// How far what was found of cameras and exposures lies from what was given.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// Over the views: medians of turns and of shifts (MedianShift), the largest of these, of the gains beside 1, and of
// focal lengths as parts of themselves.
struct CameraChanges {
  double degrees = 0, pixels = 0, most_pixels = 0, most_gain = 0, most_focal = 0;

  bool is_none() const { return degrees == 0 && most_pixels == 0 && most_gain == 0; }
};

// given, found: as many. near: distance of the near plane, world units.
CameraChanges ChangesOf(const SplatModel& model, const std::vector<const View*>& given,
                        const std::vector<ViewUnknowns>& found, double near);

}  // namespace vesta::gs
