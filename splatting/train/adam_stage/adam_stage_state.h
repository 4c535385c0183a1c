// SPDX-License-Identifier: Apache-2.0
// What the Adam stage goes on from after a break.
#pragma once

#include "problems/gaussian_splatting/scene/stage_span.h"
#include "splatting/adam/view_order.h"
#include "splatting/train/adam_stage/stage_cameras.h"
#include "splatting/train/adam_stage/trained_model.h"

namespace vesta::gs {

// All that the stage's further course depends on, beside options and photographs.
template <class B>
struct AdamStageState {
  TrainedModel<B> model;
  ViewOrder order;
  int iteration = 0;     // done
  StageSpan span{0, 0};  // of that one
  double mean_cost = 0;
  bool averages = true;      // false once the mean of the parameters has found no room
  Index before_pruning = 0;  // Gaussians that there were before some were taken out; 0: none yet
  StageCamerasState cameras = {};
  // Seconds that judging Gaussians took, and rounds of it that there was no time for (StageParsimony).
  double judged_seconds = 0;
  int judging_left_out = 0;

  // Whether what was read can be such a state.
  bool IsWhole() const {
    const bool is_within = span.before >= 0 && span.before <= span.after && span.after <= 1;
    return model.IsWhole() && iteration >= 0 && is_within && mean_cost >= 0 && before_pruning >= 0 &&
           judged_seconds >= 0 && judging_left_out >= 0;
  }
  template <class Archive>
  void Visit(Archive& archive) {
    archive(model, order, iteration, span.before, span.after, mean_cost, averages, before_pruning, cameras,
            judged_seconds, judging_left_out);
  }
};

}  // namespace vesta::gs
