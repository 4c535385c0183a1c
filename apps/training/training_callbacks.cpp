// SPDX-License-Identifier: Apache-2.0
#include "apps/training/training_callbacks.h"

#include <fmt/format.h>
#include <glog/logging.h>

#include <cstdio>

#include "apps/cli/print.h"
#include "apps/cli/process.h"
#include "apps/training/checkpointing.h"
#include "apps/viewer/viewer.h"
#include "problems/gaussian_splatting/model/scene_frame.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/io/splats/ply.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::app {
namespace {

// --log_lm: each LM iteration goes to the log, whatever the progress line shows.
void LogIteration(const gs::TrainProgress& p) {
  if (p.stage != gs::Stage::kLm) return;
  LOG(INFO) << fmt::format("lm {}: cost {:.6f} train PSNR {:.3f} {:.2f} s {}", p.iteration, p.cost, p.psnr, p.seconds,
                           p.note);
}

}  // namespace

gs::TrainCallbacks CallbacksShownOn(ProgressLine* line, bool has_lm, bool log_lm) {
  gs::TrainCallbacks callbacks;
  callbacks.progress = [line, log_lm](const gs::TrainProgress& progress) {
    if (log_lm) LogIteration(progress);
    line->Update(progress);
  };
  callbacks.predicted = [line, has_lm](const gs::Prediction& p) {
    line->Finish();
    Print("{}: {} {}, {:.0f} MiB, {:.0f} Gaussians\n", p.is_first_guess ? "a first guess" : "expected",
          FormatDuration(p.seconds), has_lm ? "up to LM" : "in all", p.mib, p.gaussians);
    std::fflush(stdout);
  };
  callbacks.stop = Interrupted;
  return callbacks;
}

void SaveOnTheWay(const Flags& flags, const gs::Scene& scene, const gs::TrainOptions& options, const OutputFolder& out,
                  gs::TrainCallbacks* callbacks) {
  callbacks->checkpoint.every = ParseInterval("checkpoint_every", flags.checkpoint_every);
  if (!callbacks->checkpoint.every.never() || !flags.view.empty()) {
    callbacks->checkpoint.path = CheckpointFile(out.path());
  }
  callbacks->snapshot_every = ParseInterval("snapshot_every", flags.snapshot_every);
  if (callbacks->snapshot_every.never()) return;
  callbacks->snapshot = [&scene, &out, options](gs::Stage stage, int iteration, const splat::Model<float>& model) {
    gs::SplatModel copy = gs::CopyOf(model);
    gs::TellRenderSettings(options, &copy);
    gs::MoveToWorld(scene, &copy);
    gs::WriteSplatPly(out.File(fmt::format("snapshot_{}_{:06}.ply", gs::StageName(stage), iteration)), copy);
  };
}

std::unique_ptr<TrainingView> ViewOfTraining(const Flags& flags, const gs::Scene& scene,
                                             const gs::TrainOptions& options) {
  if (flags.view.empty()) return nullptr;
  auto view = std::make_unique<TrainingView>(PlaceOfTrainingsView(flags), scene, ToFloat(options.background));
  Print("shown at {}\n", view->link());
  std::fflush(stdout);
  return view;
}

}  // namespace vesta::app
