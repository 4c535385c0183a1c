// SPDX-License-Identifier: Apache-2.0
// The numbers of a run as the text of a JSON file, for scripts.
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
  const Communicator* ranks = nullptr;  // null: not started by MPI
  std::vector<PhaseRow> profile = {};   // of --profile
};

// Fields as docs/guide/metrics.md lists them. test, train and held_out
// are those of the last row of the history; adam_end and lm_end the seconds of the last rows of their stages. A figure
// that is not finite is null.
std::string MetricsJson(const gs::TrainResult& result, const RunFacts& facts, const TrainSettings& settings);

// {"test", "train", "cost", "gaussians", "parameters", "device", "threads"}, as above. aligned (null: none): besides
// "aligned": {"psnr", "ssim", "moved_degrees", "moved_pixels", "not_found", "views": [{"name", "status", "psnr",
// "ssim", "degrees", "pixels"}]}, and where exposures were fitted "right_half" and "right_half_exposed", each {"psnr",
// "ssim"}, there and of each view, which then has its "gain" and "offset" too.
std::string EvaluationJson(const gs::Evaluation& evaluation, const gs::AlignedEvaluation* aligned,
                           const gs::SplatModel& model, const RunFacts& facts);

}  // namespace vesta::app
