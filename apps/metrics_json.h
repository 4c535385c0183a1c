// The numbers of a run as the text of a JSON file, for scripts.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/train_settings.h"
#include "kernels/ranks/ranks.h"
#include "problems/gaussian_splatting/cameras/aligned_evaluation.h"
#include "problems/gaussian_splatting/train/trainer.h"

namespace vesta::app {

// What a run did apart from training. Seconds count from the start of the process.
struct RunFacts {
  const char* command = "";                                           // train, refine, prune
  std::string scene = {};                                             // its folder
  std::vector<std::pair<std::string, std::string>> scene_flags = {};  // how it was read: SceneFlagTexts
  double load_seconds = 0;                                            // when the scene was loaded
  double total_seconds = 0;                                           // now, evaluation included
  double peak_memory_mib = 0;
  const char* device = "cpu";
  int threads = 0;
  const Ranks* ranks = nullptr;  // null: not started by MPI
};

// {"test": {"psnr", "ssim"}, "train": {"psnr", "ssim"}, "gaussians", "parameters", "seconds": {"load", "adam", "lm",
// "eval", "total"}, "work_megapixels", "peak_memory_mib", "memory": {"predicted_mib", "peak_mib", "budget_mib",
// "jacobian", "batches", "gpu": {"predicted_mib", "peak_mib", "free_mib"}}, "version", "command", "scene",
// "scene_flags": {...}, "device", "threads", "processes": {"count", "exchanges", "received_mib", "exchange_seconds"},
// "seed", "preset", "options": {...}, "notes": [...], "history": [...]}.
// test and train are those of the last row of the history. adam and lm: when each stage ended, evaluation left out, as
// in the rows; eval: spent in evaluation. gpu: where the stages ran on one, free_mib before them; scene_flags: those
// given of how the scene was read; processes: where MPI started them, what the first received from the others and its
// seconds for that, waiting for them among these; options: as --config reads them; notes: where something was done
// otherwise than asked for. A figure that is not finite is null.
std::string MetricsJson(const gs::TrainResult& result, const RunFacts& facts, const TrainSettings& settings);

// {"test", "train", "cost", "gaussians", "parameters", "device", "threads"}, as above. aligned (null: none): besides
// "aligned": {"psnr", "ssim", "moved_degrees", "moved_pixels", "not_found", "views": [{"name", "status", "psnr",
// "ssim", "degrees", "pixels"}]}, and where exposures were fitted "right_half" and "right_half_exposed", each {"psnr",
// "ssim"}, there and of each view, which then has its "gain" and "offset" too.
std::string EvaluationJson(const gs::Evaluation& evaluation, const gs::AlignedEvaluation* aligned,
                           const gs::SplatModel& model, const RunFacts& facts);

}  // namespace vesta::app
