// What a training records of its course.
#pragma once

#include "splatting/evaluate/quality.h"

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

}  // namespace vesta::gs
