// SPDX-License-Identifier: Apache-2.0
// A note about trainings whose test views no longer gain.
#pragma once

#include <string>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"
#include "splatting/train/session/train_result.h"

namespace vesta::app {

// One line if the test PSNR stood still in the second half of Adam's history, while the training PSNR rose; else empty.
// The line has the likely reasons: exposures that differ, few views, cameras that are not refined, and the flags that
// help. Throws Error if a photograph cannot be read.
std::string StandstillNote(const gs::Scene& scene, const std::vector<gs::HistoryRow>& history,
                           gs::CameraChoice refined);

}  // namespace vesta::app
