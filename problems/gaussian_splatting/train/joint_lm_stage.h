// Stage two where LM finds cameras, lenses and exposures too (FindsCamerasByLm): splats and views at once, in the
// memory of the host (cameras/joint_problem.h).
#pragma once

#include <string>

#include "problems/gaussian_splatting/train/session.h"

namespace vesta::gs {

// From the cameras that the session has found. eliminate_views: JointOptions has it; where the stage goes on, as it was
// when it began. Leaves model and cameras at their best and records their last state. Returns the engine's full report.
std::string RunJointLmStage(TrainingSession& session, SplatModel& model, bool eliminate_views);

}  // namespace vesta::gs
