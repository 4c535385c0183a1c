// SPDX-License-Identifier: Apache-2.0
// The results of a run as JSON, for scripts.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/settings/train_settings.h"
#include "kernels/core/profile.h"
#include "kernels/ranks/communicator.h"
#include "splatting/cameras/alignment/align_view.h"
#include "splatting/train/session/train_result.h"

namespace vesta::app {

// What metrics.json records besides the training. Times are in seconds since the start of the process.
struct RunFacts {
  const char* command = "";                                           // train, refine, prune
  std::string scene = {};                                             // scene folder
  std::vector<std::pair<std::string, std::string>> scene_flags = {};  // SceneFlagTexts
  double load_seconds = 0;                                            // when the scene was loaded
  double total_seconds = 0;  // when the results are written, evaluations included
  double peak_memory_mib = 0;
  const char* device = "cpu";
  int threads = 0;
  const Communicator* ranks = nullptr;  // null: not started by mpirun
  std::vector<PhaseRow> profile = {};   // with --profile
};

// Text of metrics.json (docs/guide/metrics.md). test, train and held_out are from the last row of the history, adam_end
// and lm_end from the last rows of the stages. Numbers that are not finite become null.
std::string MetricsJson(const gs::TrainResult& result, const RunFacts& facts, const TrainSettings& settings);

// Text for `vesta eval --json`: "test", "train", "cost" (the training loss), "eps2d", "antialiased", "gaussians",
// "parameters", "device" and "threads". If `aligned` is not null, the text also has "aligned": {"psnr", "ssim",
// "moved_degrees", "moved_pixels", "not_found", "views": [{"name", "status", "psnr", "ssim", "degrees", "pixels"}]}. If
// exposures were fitted, "aligned" and each view also have "right_half" and "right_half_exposed", each {"psnr",
// "ssim"}, and each view has "gain" and "offset".
std::string EvaluationJson(const gs::Evaluation& evaluation, const gs::AlignedEvaluation* aligned,
                           const gs::SplatModel& model, const RunFacts& facts);

}  // namespace vesta::app
