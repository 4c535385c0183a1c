#include "apps/train_and_write.h"

#include <fmt/format.h>
#include <glog/logging.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "apps/checkpointing.h"
#include "apps/commands.h"
#include "apps/doubts.h"
#include "apps/interrupt.h"
#include "apps/metrics_json.h"
#include "apps/posed_model.h"
#include "apps/print.h"
#include "apps/process.h"
#include "apps/progress.h"
#include "apps/ranks.h"
#include "apps/report/write_report.h"
#include "apps/scene_flags.h"
#include "apps/training_results.h"
#include "apps/viewer/training_view.h"
#include "apps/viewer_flags.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/core/process_memory.h"
#include "kernels/core/text_file.h"
#include "problems/gaussian_splatting/cameras/bent_as_found.h"
#include "problems/gaussian_splatting/cameras/moved_view.h"
#include "problems/gaussian_splatting/io/colmap_of_scene.h"
#include "problems/gaussian_splatting/io/ply.h"
#include "problems/gaussian_splatting/model/scene_frame.h"

namespace vesta::app {
namespace {

// --log_lm: each LM iteration goes to the log, whatever the progress line shows.
void LogIteration(const gs::TrainProgress& p) {
  if (p.stage != gs::Stage::kLm) return;
  LOG(INFO) << fmt::format("lm {}: cost {:.6f} train PSNR {:.3f} {:.2f} s {}", p.iteration, p.cost, p.psnr, p.seconds,
                           p.note);
}

gs::TrainCallbacks Callbacks(ProgressLine* line, bool log_lm) {
  gs::TrainCallbacks callbacks;
  callbacks.progress = [line, log_lm](const gs::TrainProgress& progress) {
    if (log_lm) LogIteration(progress);
    line->Update(progress);
  };
  callbacks.predicted = [line](const gs::Prediction& p) {
    line->Finish();
    Print("{}: {} in all, {:.0f} MiB, {:.0f} Gaussians\n", p.is_first_guess ? "a first guess" : "expected",
          FormatDuration(p.seconds), p.mib, p.gaussians);
    std::fflush(stdout);
  };
  callbacks.stop = Interrupted;
  return callbacks;
}

// The last row of each stage; where there is LM alone, the row it started from too.
void PrintTable(const gs::TrainResult& result) {
  constexpr const char* kRow = "{:<5} {:>9} {:>9} {:>9} {:>9} {:>10} {:>10} {:>10} {:>10}\n";
  Print(kRow, "stage", "iteration", "seconds", "gaussians", "cost", "train PSNR", "train SSIM", "test PSNR",
        "test SSIM");
  for (std::size_t i = 0; i < result.history.size(); ++i) {
    const gs::HistoryRow& row = result.history[i];
    const bool is_last_of_stage = i + 1 == result.history.size() || result.history[i + 1].stage != row.stage;
    const bool is_given_model = i == 0 && row.stage == gs::Stage::kLm;
    if (!is_given_model && !is_last_of_stage) continue;
    Print(kRow, gs::StageName(row.stage), row.iteration, Figure(row.seconds, 1), row.gaussians, Figure(row.cost, 6),
          Figure(row.train.psnr, 3), Figure(row.train.ssim, 4), Figure(row.test.psnr, 3), Figure(row.test.ssim, 4));
  }
}

// By how much a given model is better now.
void PrintGain(const gs::HistoryRow& before, const gs::HistoryRow& after) {
  Print("refined: cost {} %, train PSNR {} dB, test PSNR {} dB, test SSIM {}\n",
        Gain(100 * (after.cost / before.cost - 1), 1), Gain(after.train.psnr - before.train.psnr, 3),
        Gain(after.test.psnr - before.test.psnr, 3), Gain(after.test.ssim - before.test.ssim, 4));
}

// What --checkpoint_every and --snapshot_every ask for.
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
    gs::TellWhatItIsFor(options, &copy);
    gs::MoveToWorld(scene, &copy);
    gs::WriteSplatPly(out.File(fmt::format("snapshot_{}_{:06}.ply", gs::StageName(stage), iteration)), copy);
  };
}

// Serves the page of --view, if it is asked for, from here on.
std::unique_ptr<TrainingView> ShowOnTheWay(const Flags& flags, const gs::Scene& scene, const gs::TrainOptions& options,
                                           gs::TrainCallbacks* callbacks) {
  if (flags.view.empty()) return nullptr;
  auto view = std::make_unique<TrainingView>(PlaceOfTrainingsView(flags), scene, ToFloat(options.background));
  view->monitor().Follow(callbacks);
  Print("shown at {}\n", view->link());
  std::fflush(stdout);
  return view;
}

// A model as its file has it.
gs::SplatModel InWorld(const gs::Scene& scene, gs::SplatModel model) {
  gs::MoveToWorld(scene, &model);
  return model;
}

// Memory is foreseen, and what is foreseen can be wrong.
void NoteMemory(const gs::MemoryOptions& options, const gs::MemoryReport& report, std::vector<std::string>* notes) {
  constexpr double kMibInGib = 1024;
  const bool is_of_gpu = report.device_free_mib > 0;
  const double budget = kMibInGib * options.budget_gib, peak = is_of_gpu ? report.device_peak_mib : PeakMemoryMib();
  if (budget <= 0 || peak <= budget) return;
  notes->push_back(fmt::format("--memory_budget={}: at most {:.1f} MiB were to be taken, {:.1f} were",
                               options.budget_gib, budget, peak));
}

constexpr const char* kCameraFolder = "cameras";

// What was found of the cameras, as a COLMAP model with the scene's points. Says so in a line; none where nothing
// moved: then those of an earlier training go.
std::string SaveCameras(const gs::Scene& scene, const gs::TrainResult& result, const OutputFolder& out) {
  const gs::CameraChanges& changes = result.camera_changes;
  const std::string folder = out.File(kCameraFolder);
  if (changes.is_none()) {
    std::error_code ignored;
    for (const char* file : {"/cameras.txt", "/images.txt", "/points3D.txt", ""}) {
      std::filesystem::remove(folder + file, ignored);
    }
    return "";
  }
  constexpr double kWorthSaying = 0.1;  // pixels
  std::vector<gs::View> views = gs::MovedViews(scene, result.cameras);
  const double off = gs::BendAsFound(scene, result.cameras, &views);
  gs::WriteColmapModel(gs::ColmapOf(scene, views), folder, gs::ColmapFormat::kText);
  const auto by = [](const char* what, double part) {
    return part > 0 ? fmt::format("; {} by up to {:.1f} %", what, 100 * part) : "";
  };
  return fmt::format(
      "cameras moved by {:.2f} pixels and {:.3f} degrees (medians), {:.2f} pixels at most{}{}{}: the COLMAP model {}\n",
      changes.pixels, changes.degrees, changes.most_pixels, by("gains differ", changes.most_gain),
      by("focal lengths", changes.most_focal),
      changes.most_bend > 0 ? fmt::format("; distortion by up to {:.2f} pixels", changes.most_bend) : "",
      off > kWorthSaying ? fmt::format("{}, whose lenses meet that to {:.2f} pixels", folder, off) : folder);
}

// Test views stay as they were given, while those that the splat is of have moved.
void NoteHowToMeasure(const gs::Scene& scene, const gs::CameraChanges& changes, const std::string& path,
                      const Flags& flags, int downscale, const std::string& splat, std::vector<std::string>* notes) {
  const bool has_tests = std::ranges::any_of(scene.views, [](const gs::View& view) { return view.is_test(); });
  if (changes.is_none() || !has_tests) return;
  const bool exposed = changes.most_gain > 0, has_lenses = changes.most_focal > 0 || changes.most_bend > 0;
  std::string scene_flags = downscale > 1 ? fmt::format(" --downscale={}", downscale) : "";
  for (const auto& [name, value] : SceneFlagTexts(flags)) scene_flags += fmt::format(" --{}={}", name, value);
  notes->push_back(
      fmt::format("test views are measured by their cameras{} as given, which may be off: `vesta eval {} {}{} "
                  "--align={}` fits them first{}",
                  exposed ? " and exposures" : "", splat, path, scene_flags, exposed ? "pose+colour" : "pose",
                  has_lenses ? fmt::format(", better of a scene with the lenses as found (sparse/0 is {} there)",
                                           std::filesystem::path(splat).parent_path().append(kCameraFolder).string())
                             : ""));
}

void NoteLowPass(const gs::SplatModel& model, std::vector<std::string>* notes) {
  if (model.low_pass == splat::kLowPass) return;
  notes->push_back(fmt::format(
      "the splat is made for a low-pass filter of {} pixels^2; other viewers blur by {}: the guide says what "
      "that costs",
      model.low_pass, splat::kLowPass));
}

// Of a training that was stopped by who watches it.
std::string HowToGoOn(const CommandLine& line, const gs::TrainOptions& options, const OutputFolder& out) {
  if (line.command->command != kTrain || (options.time_limit > 0 && !Interrupted())) return "";
  const bool may_save = !line.flags.checkpoint_every.empty() || !line.flags.view.empty();
  return may_save && FileExists(CheckpointFile(out.path()))
             ? fmt::format("; go on by `vesta train --resume {}`", out.path())
             : "; no checkpoint to go on from (--checkpoint_every)";
}

void NoteOrigin(const gs::SplatModel& model, std::vector<std::string>* notes) {
  const auto& o = model.origin;
  if (o == std::array<double, 3>{}) return;
  notes->push_back(fmt::format(
      "The splat lies about ({}, {}, {}) of the scene's frame, where its floats are fine enough; its file says so",
      o[0], o[1], o[2]));
}

}  // namespace

void CheckSceneFolder(const std::string& path) {
  if (FolderExists(path)) return;
  if (FileExists(path)) Fail("{}: a file, where the scene's folder is to be named; `vesta help` shows the order", path);
  Fail("{}: no such scene folder", path);
}

void PrintScene(const gs::Scene& scene) {
  const auto count = [&](gs::ViewRole role) {
    return std::ranges::count_if(scene.views, [&](const gs::View& view) { return view.role == role; });
  };
  const auto held_out = count(gs::ViewRole::kHeldOut);
  Print("{} views to train on, {}{} to test; {} points; loaded in {:.1f} s\n", count(gs::ViewRole::kTraining),
        held_out > 0 ? fmt::format("{} held out to judge by, ", held_out) : "", count(gs::ViewRole::kTest),
        scene.points.size(), SecondsSinceStart());
  for (const std::string& note : scene.notes) Print("{}\n", note);
  std::fflush(stdout);
}

void WritesResults(const Flags& flags, const std::string& out, RunFiles* files) {
  const auto file = [&](const char* name) { files->Writes(Given("out", out), out + "/" + name); };
  file("point_cloud.ply"), file("metrics.json");
  files->WritesInto(Given("out", out), out + "/" + kCameraFolder);
  if (flags.report) file("report.html");
  if (!flags.checkpoint_every.empty() || !flags.view.empty()) files->Writes(Given("out", out), CheckpointFile(out));
}

int TrainAndWrite(const CommandLine& line, const std::string& path, const gs::Scene& scene,
                  const TrainSettings& settings, const gs::StageRunners& stages, const ExpectedModel& expected,
                  double load_seconds, OutputFolder* out,
                  const std::function<gs::TrainResult(gs::TrainCallbacks&)>& run) {
  const Flags& flags = line.flags;
  CatchInterrupts();
  Ranks* const ranks = IsStartedInRanks() ? &WorldRanks() : nullptr;
  if (!out) {
    gs::TrainCallbacks with_others;
    with_others.stop = Interrupted;
    with_others.ranks = ranks;
    run(with_others);
    return Interrupted() ? kInterruptedStatus : 0;
  }
  TrainingResults results(out);
  if (!results.Reserve(expected.most, expected.least, expected.sh_degree)) {
    Print("The disk of {} has no room for {} Gaussians, which there may be in the end\n", out->path(), expected.most);
  }
  ProgressLine progress(stdout);
  gs::TrainCallbacks callbacks = Callbacks(&progress, flags.log_lm);
  callbacks.ranks = ranks;
  SaveOnTheWay(flags, scene, settings.options, *out, &callbacks);
  callbacks.before_lm = [&](const gs::SplatModel& model) {
    // Nothing is copied where the frames are one.
    if (scene.origin == std::array<double, 3>{}) return results.SaveModel(model);
    results.SaveModel(InWorld(scene, model));
  };
  const std::unique_ptr<TrainingView> view = ShowOnTheWay(flags, scene, settings.options, &callbacks);
  gs::TrainResult result;
  try {
    result = run(callbacks);
  } catch (const Error& error) {
    if (!results.has_saved_model()) throw;
    progress.Finish();
    Fail("{}; Adam's result is in {}", error.what(), results.model_path());
  }
  progress.Finish();
  if (view) view->monitor().End();
  if (flags.log_lm && !result.lm_report.empty()) LOG(INFO) << "\n" << result.lm_report;

  const std::string cameras = SaveCameras(scene, result, *out);
  gs::MoveToWorld(scene, &result.model);
  NoteOrigin(result.model, &result.notes);
  NoteLowPass(result.model, &result.notes);
  NoteMemory(settings.options.memory, result.memory, &result.notes);
  NoteHowToMeasure(scene, result.camera_changes, path, flags, settings.options.downscale, results.model_path(),
                   &result.notes);
  for (const std::string& note : result.notes) Print("{}\n", note);
  if (!result.lm_left_out.empty()) Print("LM is left out: {}\n", result.lm_left_out);
  result.notes.insert(result.notes.begin(), scene.notes.begin(), scene.notes.end());  // told at the start
  results.Save(result.model, MetricsJson(result,
                                         {.command = line.command->name,
                                          .scene = std::filesystem::absolute(path).lexically_normal().string(),
                                          .scene_flags = SceneFlagTexts(flags),
                                          .load_seconds = load_seconds,
                                          .total_seconds = SecondsSinceStart(),
                                          .peak_memory_mib = PeakMemoryMib(),
                                          .device = stages.device.c_str(),
                                          .threads = NumThreads(),
                                          .ranks = ranks},
                                         settings));
  PrintTable(result);
  Print("{}", cameras);
  if (result.history.front().stage == gs::Stage::kLm) {  // of a given model
    if (result.history.size() > 1) PrintGain(result.history.front(), result.history.back());
    Print("{}", DoubtOfScene(result.history.front().train.psnr));
  } else if (!result.stopped) {
    Print("{}", DoubtOfTraining(scene, result.history.back().train.psnr));
  }
  Print("{}wrote {} and {}{}\n", result.stopped ? "stopped early; " : "", results.model_path(), results.metrics_path(),
        result.stopped ? HowToGoOn(line, settings.options, *out) : "");
  if (flags.report) {
    std::fflush(stdout);
    gs::MoveToScene(scene, &result.model);
    WriteReport(results.report_path(), {{ReadRun(out->path()), SceneToReport(path, settings.options.downscale)}},
                [&](std::size_t) {
                  return PosedSplat{&result.model, &scene};
                });
    Print("wrote {}\n", results.report_path());
  }
  return Interrupted() ? kInterruptedStatus : 0;
}

}  // namespace vesta::app
