// SPDX-License-Identifier: Apache-2.0
// The course of a training, and its result.
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

// One evaluation of the model during training.
struct HistoryRow {
  Stage stage = Stage::kAdam;
  int iteration = 0;
  double seconds = 0;  // since the start of the process, evaluation left out
  double cost = 0;     // mean over training views, pixels and channels of 0.8 |e| + 0.2 (1 - SSIM)
  Quality train, held_out, test;
  Index gaussians = 0;
};

// What was foreseen and chosen (memory_plan.h).
struct MemoryReport {
  double predicted_mib = 0;  // most that the process would hold, from the model that LM started from
  // The same of the GPU, what it had free before the run, and most that was in use; 0 without one.
  double device_predicted_mib = 0, device_free_mib = 0, device_peak_mib = 0;
  JacobianKind jacobian = JacobianKind::kCachedViews;
  int batches = 1;
};

struct TrainResult {
  MemoryReport memory;
  SplatModel model;
  std::vector<ViewUnknowns> cameras;  // of the training views, from as they were given; empty: as they were given
  CameraChanges camera_changes;
  std::vector<HistoryRow> history;                            // not empty; the last row is that of the model
  double adam_seconds = 0, lm_seconds = 0, eval_seconds = 0;  // spent in each
  bool stopped = false;                                       // by the callback or the time limit
  bool saved = false;                                         // a checkpoint, on the way
  std::string lm_report;                                      // the engine's full report, empty without LM
  std::string lm_left_out;                                    // why LM did not run though asked for; else empty
  std::vector<std::string> notes;                             // what was done otherwise than asked for, a line each
};

}  // namespace vesta::gs
