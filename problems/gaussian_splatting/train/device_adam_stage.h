// Stage one on a GPU.
#pragma once

#include "problems/gaussian_splatting/train/session.h"

namespace vesta::gs {

// As RunAdamStage.
void RunDeviceAdamStage(TrainingSession& session, SplatModel& model);

}  // namespace vesta::gs
