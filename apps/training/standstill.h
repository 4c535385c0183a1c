// SPDX-License-Identifier: Apache-2.0
// A note about trainings whose test views no longer gain.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"
#include "splatting/train/session/train_result.h"

namespace vesta::app {

// One line if the test PSNR stood still in the second half of Adam's history, while the training PSNR rose; else empty.
// The line has the possible reasons, with the flags that help: few views, cameras that are not refined, and exposures
// that differ. exposure_spread: computes ExposureSpread (apps/doctor/exposures.h), NaN if unknown; called only for a
// line.
std::string StandstillNote(const gs::Scene& scene, const std::vector<gs::HistoryRow>& history, gs::CameraChoice refined,
                           const std::function<double()>& exposure_spread);

}  // namespace vesta::app
