// SPDX-License-Identifier: Apache-2.0
// Shared by all commands that train: the training as a job, what it does on the way, its outputs, and remarks on its
// result.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/cli/flags.h"
#include "apps/cli/outputs.h"
#include "apps/cli/print.h"
#include "apps/settings/train_settings.h"
#include "apps/viewer/viewer.h"
#include "splatting/train/session/stage_runners.h"
#include "splatting/train/session/train_callbacks.h"
#include "splatting/train/session/train_result.h"

namespace vesta::app {

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

// A line each: where the splat lies, what it is to be shown with, how to measure it, memory beyond what was asked for.
// result: of the job, its model in the scene's world. splat: the file that it is written to.
std::vector<std::string> RemarksOn(const TrainingJob& job, const gs::TrainResult& result, const std::string& splat);

// Of a training that was stopped by who watches it: how to go on; else nothing. Of the process that writes.
std::string HowToGoOn(const TrainingJob& job, const gs::TrainResult& result);

// The files that a training into the folder will write, as far as their names are known.
void WritesResults(const Flags& flags, const std::string& out, RunFiles* files);

// One of the trainer's functions, to be called with these callbacks.
using TrainRun = std::function<gs::TrainResult(gs::TrainCallbacks&)>;

// Trains and writes the results, complete or stopped. Returns the exit status.
int TrainAndWrite(const TrainingJob& job, const TrainRun& run);

// Shows the training on the line, and the log where --log_lm asks for it; an interrupt stops it. has_lm: whether LM
// follows the Adam stage, which alone is foretold.
gs::TrainCallbacks CallbacksShownOn(ProgressLine* line, bool has_lm, bool log_lm);

// What --checkpoint_every and --snapshot_every ask for. scene, out: must outlive the training.
void SaveOnTheWay(const Flags& flags, const gs::Scene& scene, const gs::TrainOptions& options, const OutputFolder& out,
                  gs::TrainCallbacks* callbacks);

// Serves the page of --view from here on, of a training that its monitor is to follow; null where it is not asked for.
// scene: must outlive the page.
std::unique_ptr<TrainingView> ViewOfTraining(const Flags& flags, const gs::Scene& scene,
                                             const gs::TrainOptions& options);

}  // namespace vesta::app
