// SPDX-License-Identifier: Apache-2.0
// The common part of train, refine and prune: runs a training with progress line, checkpoints and page, then writes and
// prints the results.
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

// most: the largest number of Gaussians that the result will probably have. least: the number at the start.
struct ExpectedModel {
  Index most, least;
  int sh_degree;
};

// Referenced objects must outlive TrainAndWrite.
struct TrainingJob {
  const CommandLine& line;
  const std::string& path;  // as on the command line
  const gs::Scene& scene;
  const TrainSettings& settings;
  const gs::StageRunners& stages;
  ExpectedModel expected;
  double load_seconds;
  OutputFolder* out;  // null except on rank 0, which writes the results
};

// Notes for the user, one line each: about the origin and eps2d of the splat, its evaluation, and exceeded memory
// budgets. result.model must be in world coordinates. splat: path of the written splat file.
std::vector<std::string> NotesOn(const TrainingJob& job, const gs::TrainResult& result, const std::string& splat);

// Text that says how to resume a training that the user stopped; else empty. Only for rank 0.
std::string ResumeHint(const TrainingJob& job, const gs::TrainResult& result);

// Adds the outputs of a training with --out=`out` to `files`.
void RegisterResults(const Flags& flags, const std::string& out, RunFiles* files);

// Calls gs::Train or gs::Refine with these callbacks.
using TrainRun = std::function<gs::TrainResult(gs::TrainCallbacks&)>;

// Trains, then writes and prints the results, even if the training was interrupted. Returns the exit status.
int TrainAndWrite(const TrainingJob& job, const TrainRun& run);

// Callbacks that show the progress on `line`, log each LM iteration if log_lm, and stop the training after Ctrl-C.
// has_lm: an LM stage follows. The time predicted at the start does not include it.
gs::TrainCallbacks CallbacksShownOn(ProgressLine* line, bool has_lm, bool log_lm);

// Callbacks that write checkpoints and snapshots (--checkpoint_every, --snapshot_every). scene and out must outlive the
// training.
void SetSaveCallbacks(const Flags& flags, const gs::Scene& scene, const gs::TrainOptions& options,
                      const OutputFolder& out, gs::TrainCallbacks* callbacks);

// Starts the server of --view; returns null without this flag. Call TrainingMonitor::Follow before the training. scene
// must outlive the result.
std::unique_ptr<TrainingView> ViewOfTraining(const Flags& flags, const gs::Scene& scene,
                                             const gs::TrainOptions& options);

}  // namespace vesta::app
