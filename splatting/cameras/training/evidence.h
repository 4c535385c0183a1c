// SPDX-License-Identifier: Apache-2.0
// Whether the cameras of a scene are worth finding along with its splat: what views that the splat has not seen gain by
// being fitted to it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

struct CameraEvidence {
  int views = 0;      // that were fitted; 0: nothing is known
  double pose = 0;    // part of their loss that goes when their cameras are fitted, median
  double pixels = 0;  // MedianShift that this takes, median
  // By how much smaller the error of their right halves is, as PSNR has it, with exposures of their left ones.
  double exposure = 0;

  // What it speaks for, poses or nothing. The bound lies between what scenes with poses by bundle adjustment say and
  // what the same say with cameras that are off (docs/results/2026-11-25-cameras-in-training.md). Exposures are not
  // chosen: a view whose own is not known is rendered worse with the mean one than with its neighbours'.
  CameraChoice Choice() const;
  std::string Words() const;
};

// Views of which the splat knows nothing. background: 0..1. near: distance of the near plane, world units.
CameraEvidence EvidenceOf(const SplatModel& model, const std::vector<View>& views,
                          const std::array<double, 3>& background, double near);

}  // namespace vesta::gs
