// SPDX-License-Identifier: Apache-2.0
// What the commands that train have in common: they train by one of the trainer's functions, show it, and write
// DIR/point_cloud.ply, DIR/metrics.json and DIR/report.html.
#pragma once

#include <functional>
#include <string>

#include "apps/cli/flags.h"
#include "apps/cli/outputs.h"
#include "apps/training/training_job.h"
#include "splatting/train/session/train_callbacks.h"

namespace vesta::app {

// The files that a training into the folder will write, as far as their names are known.
void WritesResults(const Flags& flags, const std::string& out, RunFiles* files);

// One of the trainer's functions, to be called with these callbacks.
using TrainRun = std::function<gs::TrainResult(gs::TrainCallbacks&)>;

// Trains and writes the results, complete or stopped. Returns the exit status.
int TrainAndWrite(const TrainingJob& job, const TrainRun& run);

}  // namespace vesta::app
