// SPDX-License-Identifier: Apache-2.0
// Shared by train, refine and prune: runs a training with its progress line, checkpoints and page, and writes and
// prints its results.
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

// The largest expected and the initial number of Gaussians, and their SH degree.
struct ExpectedModel {
  Index most, least;
  int sh_degree;
};

// All referenced objects must outlive the job.
struct TrainingJob {
  const CommandLine& line;
  const std::string& path;  // scene folder, as given
  const gs::Scene& scene;
  const TrainSettings& settings;
  const gs::StageRunners& stages;
  ExpectedModel expected;
  double load_seconds;
  OutputFolder* out;  // null on all ranks except rank 0, which writes the results
};

// Notes for the user, one line each: origin and eps2d of the splat, how to measure it, and exceeded memory budgets.
// result: its model must be in world coordinates. splat: the file of the splat.
std::vector<std::string> NotesOn(const TrainingJob& job, const gs::TrainResult& result, const std::string& splat);

// For a training that the user stopped: how to resume it; else empty. For rank 0.
std::string ResumeHint(const TrainingJob& job, const gs::TrainResult& result);

// Registers the output files of a training, as far as their names are known.
void RegisterResults(const Flags& flags, const std::string& out, RunFiles* files);

// Calls gs::Train or gs::Refine with these callbacks.
using TrainRun = std::function<gs::TrainResult(gs::TrainCallbacks&)>;

// Trains and writes the results, also after a stop. Returns the exit status.
int TrainAndWrite(const TrainingJob& job, const TrainRun& run);

// Callbacks that show the progress on `line`, log LM iterations for log_lm, and stop on an interrupt. has_lm: whether
// an LM stage follows; predictions cover only the Adam stage.
gs::TrainCallbacks CallbacksShownOn(ProgressLine* line, bool has_lm, bool log_lm);

// Sets the callbacks for --checkpoint_every and --snapshot_every. scene, out: must outlive the training.
void SetSaveCallbacks(const Flags& flags, const gs::Scene& scene, const gs::TrainOptions& options,
                      const OutputFolder& out, gs::TrainCallbacks* callbacks);

// Starts to serve the page of --view; its monitor must then follow the training. Null without --view. scene: must
// outlive the page.
std::unique_ptr<TrainingView> ViewOfTraining(const Flags& flags, const gs::Scene& scene,
                                             const gs::TrainOptions& options);

}  // namespace vesta::app
