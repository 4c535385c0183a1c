// SPDX-License-Identifier: Apache-2.0
// Shared by all commands that train: the training as a job, its outputs, and remarks on its result.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/cli/flags.h"
#include "apps/cli/outputs.h"
#include "apps/settings/train_settings.h"
#include "splatting/train/session/stage_runners.h"
#include "splatting/train/session/train_callbacks.h"
#include "splatting/train/session/train_result.h"

namespace vesta::app {

// A training that a command runs, and remarks on its result.

// A training that a command has made ready.

// How many Gaussians there may be in the end, to begin with, and the degree of their harmonics.
struct ExpectedModel {
  Index most, least;
  int sh_degree;
};

// What it refers to must outlive it.
struct TrainingJob {
  const CommandLine& line;
  const std::string& path;  // of the scene, as given
  const gs::Scene& scene;
  const TrainSettings& settings;
  const gs::StageRunners& stages;
  ExpectedModel expected;
  double load_seconds;
  OutputFolder* out;  // null for all processes but the first, which writes for all
};

// What there is to say of the result of a training, beside its figures.

// A line each: where the splat lies, what it is to be shown with, how to measure it, memory beyond what was asked for.
// result: of the job, its model in the scene's world. splat: the file that it is written to.
std::vector<std::string> RemarksOn(const TrainingJob& job, const gs::TrainResult& result, const std::string& splat);

// Of a training that was stopped by who watches it: how to go on; else nothing. Of the process that writes.
std::string HowToGoOn(const TrainingJob& job, const gs::TrainResult& result);

// What the commands that train have in common: they train by one of the trainer's functions, show it, and write
// DIR/point_cloud.ply, DIR/metrics.json and DIR/report.html.

// The files that a training into the folder will write, as far as their names are known.
void WritesResults(const Flags& flags, const std::string& out, RunFiles* files);

// One of the trainer's functions, to be called with these callbacks.
using TrainRun = std::function<gs::TrainResult(gs::TrainCallbacks&)>;

// Trains and writes the results, complete or stopped. Returns the exit status.
int TrainAndWrite(const TrainingJob& job, const TrainRun& run);

}  // namespace vesta::app
