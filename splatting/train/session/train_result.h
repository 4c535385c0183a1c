// SPDX-License-Identifier: Apache-2.0
// The result and the history of a training.
#pragma once

#include <string>
#include <vector>

#include "problems/gaussian_splatting/lm/lm_stage_options.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/cameras/unknowns/view_unknowns.h"
#include "splatting/evaluate/evaluation.h"

namespace vesta::gs {

enum class Stage { kAdam, kLm };
inline const char* StageName(Stage stage) { return stage == Stage::kAdam ? "adam" : "lm"; }

// One evaluation during training.
struct HistoryRow {
  Stage stage = Stage::kAdam;
  int iteration = 0;
  double seconds = 0;  // TrainingClock: from the start of the process, without evaluations
  double cost = 0;     // mean over training views, pixels and channels of 0.8 |e| + 0.2 (1 - SSIM)
  Quality train, held_out, test;
  Index gaussians = 0;
};

// Predicted and measured memory, and how LM ran (memory_plan.h).
struct MemoryReport {
  double predicted_mib = 0;  // peak of the process
  // Of the GPU: predicted peak, free memory before the run, and measured peak; 0 without a GPU.
  double device_predicted_mib = 0, device_free_mib = 0, device_peak_mib = 0;
  JacobianKind jacobian = JacobianKind::kCachedViews;
  int batches = 1;
};

struct TrainResult {
  MemoryReport memory;
  SplatModel model;
  std::vector<ViewUnknowns> cameras;  // of the training views relative to the given cameras; empty without refinement
  CameraChanges camera_changes;
  std::vector<HistoryRow> history;                            // not empty; the last row evaluates `model`
  double adam_seconds = 0, lm_seconds = 0, eval_seconds = 0;  // since the start or resume
  bool stopped = false;                                       // early, by the callback or the time limit
  bool saved = false;                                         // a checkpoint was written
  std::string lm_report;                                      // the solver's full report, empty without LM
  std::string lm_left_out;                                    // why requested LM did not run; else empty
  std::vector<std::string> notes;                             // deviations from the options, one line each
};

}  // namespace vesta::gs
