// SPDX-License-Identifier: Apache-2.0
#include "apps/training/train_and_write.h"

#include <fmt/format.h>
#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <system_error>
#include <utility>

#include "apps/cli/print.h"
#include "apps/cli/process.h"
#include "apps/device/ranks.h"
#include "apps/doctor/exposures.h"
#include "apps/inputs/input_warnings.h"
#include "apps/inputs/scene_and_splat.h"
#include "apps/report/report.h"
#include "apps/training/checkpointing.h"
#include "apps/training/metrics_json.h"
#include "apps/training/standstill.h"
#include "apps/training/training_results.h"
#include "apps/viewer/viewer.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/core/process_memory.h"
#include "kernels/core/profile.h"
#include "problems/gaussian_splatting/model/scene_frame.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/io/scenes/colmap.h"
#include "splatting/io/splats/ply.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::app {
namespace {

using Remarks = std::vector<std::string>;

void RemarkOnOrigin(const gs::SplatModel& model, Remarks* remarks) {
  const auto& o = model.origin;
  if (o == std::array<double, 3>{}) return;
  remarks->push_back(fmt::format(
      "The splat is stored relative to the origin ({}, {}, {}) of the scene, for the precision of its floats; its file "
      "records the origin",
      o[0], o[1], o[2]));
}

void NoteFilter(const gs::SplatModel& model, Remarks* remarks) {
  if (model.antialiased) {
    remarks->push_back(
        "the splat is trained with --antialias; viewers that do not read this from its file show it too opaque (see "
        "the guide)");
  }
  if (model.eps2d == splat::kEps2d) return;
  remarks->push_back(fmt::format(
      "the splat is trained with --eps2d={} pixels^2, but other viewers use {} and show it worse (see the guide)",
      model.eps2d, splat::kEps2d));
}

// The memory plan is an estimate, so the budget can be exceeded.
void RemarkOnMemory(const gs::MemoryOptions& options, const gs::MemoryReport& report, Remarks* remarks) {
  constexpr double kMibInGib = 1024;
  const bool is_of_gpu = report.device_free_mib > 0;
  const double budget = kMibInGib * options.budget_gib, peak = is_of_gpu ? report.device_peak_mib : PeakMemoryMib();
  if (budget <= 0 || peak <= budget) return;
  remarks->push_back(fmt::format("--memory_budget={}: the limit was {:.1f} MiB, but {:.1f} MiB were used",
                                 options.budget_gib, budget, peak));
}

// Refined cameras have moved the splat, but not the test cameras.
void RemarkOnMeasuring(const TrainingJob& job, const gs::CameraChanges& changes, const std::string& splat,
                       Remarks* remarks) {
  const bool has_tests = std::ranges::any_of(job.scene.views, [](const gs::View& view) { return view.is_test(); });
  if (changes.is_none() || !has_tests) return;
  const bool exposed = changes.most_gain > 0, has_lenses = changes.most_focal > 0;
  const int downscale = job.settings.options.downscale;
  std::string scene_flags = downscale > 1 ? fmt::format(" --downscale={}", downscale) : "";
  for (const auto& [name, value] : SceneFlagTexts(job.line.flags)) scene_flags += fmt::format(" --{}={}", name, value);
  remarks->push_back(fmt::format(
      "the test views are measured with their cameras{} as given, which may be inaccurate: `vesta eval {} {}{} "
      "--align={}` fits them first{}",
      exposed ? " and exposures" : "", splat, job.path, scene_flags, exposed ? "pose+colour" : "pose",
      has_lenses ? fmt::format("; better with a scene that has the refined lenses ({} as its sparse/0)",
                               std::filesystem::path(splat).parent_path().append(kCameraFolder).string())
                 : ""));
}

// The model at the start of refine or prune, and the last row of each stage.
void PrintTable(const gs::TrainResult& result) {
  constexpr const char* kRow = "{:<5} {:>9} {:>9} {:>9} {:>13} {:>10} {:>10} {:>10} {:>10}\n";
  Print(kRow, "stage", "iteration", "seconds", "gaussians", "training loss", "train PSNR", "train SSIM", "test PSNR",
        "test SSIM");
  for (std::size_t i = 0; i < result.history.size(); ++i) {
    const gs::HistoryRow& row = result.history[i];
    const bool is_last_of_stage = i + 1 == result.history.size() || result.history[i + 1].stage != row.stage;
    const bool is_first_model = i == 0 && row.stage == gs::Stage::kLm;
    if (!is_first_model && !is_last_of_stage) continue;
    Print(kRow, is_first_model ? "start" : gs::StageName(row.stage), row.iteration, Figure(row.seconds, 1),
          row.gaussians, Figure(row.cost, 6), Figure(row.train.psnr, 3), Figure(row.train.ssim, 4),
          Figure(row.test.psnr, 3), Figure(row.test.ssim, 4));
  }
}

// Change of an existing model. done: "refined" or "pruned".
void PrintGain(const char* done, const gs::HistoryRow& before, const gs::HistoryRow& after) {
  Print("{}: training loss {} %, train PSNR {} dB, test PSNR {} dB, test SSIM {}\n", done,
        Gain(100 * (after.cost / before.cost - 1), 1), Gain(after.train.psnr - before.train.psnr, 3),
        Gain(after.test.psnr - before.test.psnr, 3), Gain(after.test.ssim - before.test.ssim, 4));
}

// Null without mpirun.
Communicator* TrainingCommunicator() { return IsStartedInRanks() ? &WorldCommunicator() : nullptr; }

// Trains with progress line, page, checkpoints and snapshots. Writes the result of Adam before LM begins. view: the
// page, or null.
gs::TrainResult TrainShown(const TrainingJob& job, const TrainRun& run, TrainingView* view, TrainingResults* results) {
  const Flags& flags = job.line.flags;
  ProgressLine progress(stdout);
  gs::TrainCallbacks callbacks = CallbacksShownOn(&progress, job.settings.options.lm.iterations > 0, flags.log_lm);
  callbacks.ranks = TrainingCommunicator();
  SetSaveCallbacks(flags, job.scene, job.settings.options, *job.out, &callbacks);
  if (view) view->monitor().Follow(&callbacks);
  callbacks.before_lm = [&](const gs::SplatModel& model) {
    // Without an offset, the model is in world coordinates: no copy.
    if (job.scene.origin == std::array<double, 3>{}) return results->SaveModel(model);
    gs::SplatModel in_world = model;
    gs::MoveToWorld(job.scene, &in_world);
    results->SaveModel(in_world);
  };
  gs::TrainResult result;
  try {
    result = run(callbacks);
  } catch (const Error& error) {
    if (!results->has_saved_model()) throw;
    progress.Finish();
    Fail(error.code(), "{}; the result of the Adam stage is in {}", error.what(), results->model_path());
  }
  progress.Finish();
  if (view) view->monitor().End();
  if (flags.log_lm && !result.lm_report.empty()) LOG(INFO) << "\n" << result.lm_report;
  return result;
}

void SaveResults(const TrainingJob& job, const gs::TrainResult& result, TrainingResults* results) {
  results->Save(result.model,
                MetricsJson(result,
                            {.command = job.line.command->name,
                             .scene = std::filesystem::absolute(job.path).lexically_normal().string(),
                             .scene_flags = SceneFlagTexts(job.line.flags),
                             .load_seconds = job.load_seconds,
                             .total_seconds = SecondsSinceStart(),
                             .peak_memory_mib = PeakMemoryMib(),
                             .device = job.stages.device.c_str(),
                             .threads = NumThreads(),
                             .ranks = TrainingCommunicator(),
                             .profile = Profile::Current() ? Profile::Current()->Rows() : std::vector<PhaseRow>()},
                            job.settings));
}

// Prints the results, and warnings about them.
void PrintOutcome(const TrainingJob& job, const gs::TrainResult& result, const std::string& cameras) {
  PrintTable(result);
  Print("{}", cameras);
  if (result.history.front().stage == gs::Stage::kLm) {  // an existing model
    if (result.history.size() > 1) {
      PrintGain(job.line.command->command == kPrune ? "pruned" : "refined", result.history.front(),
                result.history.back());
    }
    Print("{}", WarningOfScene(result.history.front().train.psnr));
  } else if (!result.stopped) {
    Print("{}", WarningOfTraining(job.scene, result.history.back().train.psnr));
  }
}

// Afterwards the model is in the frame of the scene.
void WriteOwnReport(const TrainingJob& job, const TrainingResults& results, gs::SplatModel* model) {
  std::fflush(stdout);
  gs::MoveToScene(job.scene, model);
  WriteReport(results.report_path(),
              {{ReadRun(job.out->path()), SceneToReport(job.path, job.settings.options.downscale)}}, [&](std::size_t) {
                return PosedSplat{model, &job.scene};
              });
  Print("wrote {}\n", results.report_path());
}

// For the other ranks, which write nothing.
void TrainWithOthers(const TrainRun& run) {
  gs::TrainCallbacks callbacks;
  callbacks.stop = Interrupted;
  callbacks.ranks = TrainingCommunicator();
  run(callbacks);
}

void TrainAsFirst(const TrainingJob& job, const TrainRun& run) {
  TrainingResults results(job.out);
  const ExpectedModel& expected = job.expected;
  if (!results.Reserve(expected.most, expected.least, expected.sh_degree)) {
    Print("The disk of {} has no space for {} Gaussians, which the result may have\n", job.out->path(), expected.most);
  }
  // Lives until the results are written, so that the page shows the end.
  const std::unique_ptr<TrainingView> view = ViewOfTraining(job.line.flags, job.scene, job.settings.options);
  gs::TrainResult result = TrainShown(job, run, view.get(), &results);
  gs::MoveToWorld(job.scene, &result.model);
  for (std::string& remark : NotesOn(job, result, results.model_path())) result.notes.push_back(std::move(remark));
  for (const std::string& note : result.notes) Print("{}\n", note);
  if (!result.lm_left_out.empty()) Print("LM is skipped: {}\n", result.lm_left_out);
  result.notes.insert(result.notes.begin(), job.scene.notes.begin(), job.scene.notes.end());  // printed at the start
  SaveResults(job, result, &results);
  std::string cameras, no_cameras;
  try {
    cameras = SaveCameras(job.scene, result, *job.out);
  } catch (const Error& error) {
    no_cameras = error.what();
  }
  PrintOutcome(job, result, cameras);
  Print("{}wrote {} and {}{}\n", result.stopped ? "stopped early; " : "", results.model_path(), results.metrics_path(),
        result.stopped ? ResumeHint(job, result) : "");
  if (job.line.flags.report) WriteOwnReport(job, results, &result.model);
  if (!no_cameras.empty())
    Fail(kCannotWrite, "{}; the splat is in {}, but the refined cameras are not saved", no_cameras,
         results.model_path());
}

// --log_lm: logs every LM iteration.
void LogIteration(const gs::TrainProgress& p) {
  if (p.stage != gs::Stage::kLm) return;
  LOG(INFO) << fmt::format("lm {}: training loss {:.6f} train PSNR {:.3f} {:.2f} s {}", p.iteration, p.cost, p.psnr,
                           p.seconds, p.note);
}

}  // namespace

std::vector<std::string> NotesOn(const TrainingJob& job, const gs::TrainResult& result, const std::string& splat) {
  Remarks remarks;
  RemarkOnOrigin(result.model, &remarks);
  NoteFilter(result.model, &remarks);
  RemarkOnMemory(job.settings.options.memory, result.memory, &remarks);
  const auto exposure_spread = [&] {
    constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
    try {
      const gs::PointTracks tracks = gs::ReadTracks(job.path, job.scene);
      return tracks.empty() ? kUnknown : ExposureSpread(ExposureStops(job.scene, tracks));
    } catch (const Error&) {  // damaged tracks, or the files have changed: the result must not be lost
      return kUnknown;
    }
  };
  const std::string standstill =
      StandstillNote(job.scene, result.history, job.settings.options.cameras.refine, exposure_spread);
  if (!standstill.empty()) remarks.push_back(standstill);
  RemarkOnMeasuring(job, result.camera_changes, splat, &remarks);
  return remarks;
}

std::string ResumeHint(const TrainingJob& job, const gs::TrainResult& result) {
  const Flags& flags = job.line.flags;
  if (job.line.command->command != kTrain) return "";
  if (job.settings.options.time_limit > 0 && !Interrupted()) return "";
  // The resumed checkpoint belongs to this training if it is in the same folder.
  std::error_code ignored;
  const bool goes_on = !flags.resume.empty() && std::filesystem::equivalent(flags.resume, job.out->path(), ignored);
  return result.saved || goes_on ? fmt::format("; continue with `vesta train --resume {}`", job.out->path())
                                 : "; there is no checkpoint to resume from (--checkpoint_every)";
}

void RegisterResults(const Flags& flags, const std::string& out, RunFiles* files) {
  const auto file = [&](const char* name) { files->Writes(FlagText("out", out), out + "/" + name); };
  file("point_cloud.ply"), file("metrics.json");
  files->WritesFolder(FlagText("out", out), out + "/" + kCameraFolder);
  if (flags.report) file("report.html");
  if (!flags.checkpoint_every.empty() || !flags.view.empty()) files->Writes(FlagText("out", out), CheckpointFile(out));
}

int TrainAndWrite(const TrainingJob& job, const TrainRun& run) {
  CatchInterrupts();
  if (job.out) {
    TrainAsFirst(job, run);
  } else {
    TrainWithOthers(run);
  }
  return Interrupted() ? kInterruptedStatus : 0;
}

gs::TrainCallbacks CallbacksShownOn(ProgressLine* line, bool has_lm, bool log_lm) {
  gs::TrainCallbacks callbacks;
  callbacks.progress = [line, log_lm](const gs::TrainProgress& progress) {
    if (log_lm) LogIteration(progress);
    line->Update(progress);
  };
  callbacks.predicted = [line, has_lm](const gs::Prediction& p) {
    line->Finish();
    Print("{}: {} {}, {:.0f} MiB, {:.0f} Gaussians at the end\n", p.is_first_guess ? "first estimate" : "estimate",
          FormatDuration(p.seconds), has_lm ? "until LM" : "in total", p.mib, p.gaussians);
    std::fflush(stdout);
  };
  callbacks.stop = Interrupted;
  return callbacks;
}

void SetSaveCallbacks(const Flags& flags, const gs::Scene& scene, const gs::TrainOptions& options,
                      const OutputFolder& out, gs::TrainCallbacks* callbacks) {
  callbacks->checkpoint.every = ParseInterval("checkpoint_every", flags.checkpoint_every);
  if (!callbacks->checkpoint.every.never() || !flags.view.empty()) {
    callbacks->checkpoint.path = CheckpointFile(out.path());
  }
  callbacks->snapshot_every = ParseInterval("snapshot_every", flags.snapshot_every);
  if (callbacks->snapshot_every.never()) return;
  callbacks->snapshot = [&scene, &out, options](gs::Stage stage, int iteration, const splat::Model<float>& model) {
    gs::SplatModel copy = gs::CopyOf(model);
    gs::SetRenderSettings(options, &copy);
    gs::MoveToWorld(scene, &copy);
    gs::WriteSplatPly(out.File(fmt::format("snapshot_{}_{:06}.ply", gs::StageName(stage), iteration)), copy);
  };
}

std::unique_ptr<TrainingView> ViewOfTraining(const Flags& flags, const gs::Scene& scene,
                                             const gs::TrainOptions& options) {
  if (flags.view.empty()) return nullptr;
  auto view = std::make_unique<TrainingView>(AddressOfTrainingView(flags), scene, ToFloat(options.background));
  Print("page: {}\n", view->link());
  std::fflush(stdout);
  return view;
}

}  // namespace vesta::app
