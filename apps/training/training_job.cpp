// SPDX-License-Identifier: Apache-2.0
#include "apps/training/training_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>

#include "apps/cli/process.h"
#include "apps/inputs/scene_flags.h"
#include "apps/training/camera_files.h"
#include "kernels/core/process_memory.h"

namespace vesta::app {
namespace {

using Remarks = std::vector<std::string>;

void RemarkOnOrigin(const gs::SplatModel& model, Remarks* remarks) {
  const auto& o = model.origin;
  if (o == std::array<double, 3>{}) return;
  remarks->push_back(fmt::format(
      "The splat lies about ({}, {}, {}) of the scene's frame, where its floats are fine enough; its file says so",
      o[0], o[1], o[2]));
}

void RemarkOnLowPass(const gs::SplatModel& model, Remarks* remarks) {
  if (model.low_pass == splat::kLowPass) return;
  remarks->push_back(fmt::format(
      "the splat is made for a low-pass filter of {} pixels^2; other viewers blur by {}: the guide says what "
      "that costs",
      model.low_pass, splat::kLowPass));
}

// Memory is foreseen, and what is foreseen can be wrong.
void RemarkOnMemory(const gs::MemoryOptions& options, const gs::MemoryReport& report, Remarks* remarks) {
  constexpr double kMibInGib = 1024;
  const bool is_of_gpu = report.device_free_mib > 0;
  const double budget = kMibInGib * options.budget_gib, peak = is_of_gpu ? report.device_peak_mib : PeakMemoryMib();
  if (budget <= 0 || peak <= budget) return;
  remarks->push_back(fmt::format("--memory_budget={}: at most {:.1f} MiB were to be taken, {:.1f} were",
                                 options.budget_gib, budget, peak));
}

// Test views stay as they were given, while those that the splat is of have moved.
void RemarkOnMeasuring(const TrainingJob& job, const gs::CameraChanges& changes, const std::string& splat,
                       Remarks* remarks) {
  const bool has_tests = std::ranges::any_of(job.scene.views, [](const gs::View& view) { return view.is_test(); });
  if (changes.is_none() || !has_tests) return;
  const bool exposed = changes.most_gain > 0, has_lenses = changes.most_focal > 0;
  const int downscale = job.settings.options.downscale;
  std::string scene_flags = downscale > 1 ? fmt::format(" --downscale={}", downscale) : "";
  for (const auto& [name, value] : SceneFlagTexts(job.line.flags)) scene_flags += fmt::format(" --{}={}", name, value);
  remarks->push_back(
      fmt::format("test views are measured by their cameras{} as given, which may be off: `vesta eval {} {}{} "
                  "--align={}` fits them first{}",
                  exposed ? " and exposures" : "", splat, job.path, scene_flags, exposed ? "pose+colour" : "pose",
                  has_lenses ? fmt::format(", better of a scene with the lenses as found (sparse/0 is {} there)",
                                           std::filesystem::path(splat).parent_path().append(kCameraFolder).string())
                             : ""));
}

}  // namespace

std::vector<std::string> RemarksOn(const TrainingJob& job, const gs::TrainResult& result, const std::string& splat) {
  Remarks remarks;
  RemarkOnOrigin(result.model, &remarks);
  RemarkOnLowPass(result.model, &remarks);
  RemarkOnMemory(job.settings.options.memory, result.memory, &remarks);
  RemarkOnMeasuring(job, result.camera_changes, splat, &remarks);
  return remarks;
}

std::string HowToGoOn(const TrainingJob& job, const gs::TrainResult& result) {
  const Flags& flags = job.line.flags;
  if (job.line.command->command != kTrain) return "";
  if (job.settings.options.time_limit > 0 && !Interrupted()) return "";
  // That it was gone on with from is of this training too; any other may lie there.
  std::error_code ignored;
  const bool goes_on = !flags.resume.empty() && std::filesystem::equivalent(flags.resume, job.out->path(), ignored);
  return result.saved || goes_on ? fmt::format("; go on by `vesta train --resume {}`", job.out->path())
                                 : "; no checkpoint to go on from (--checkpoint_every)";
}

}  // namespace vesta::app
