// SPDX-License-Identifier: Apache-2.0
// When the Adam stage does what. The stage walks this schedule, and so does the forecast of what is left of it.
#pragma once

#include "problems/gaussian_splatting/scene/stage_span.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::gs {

// All that one iteration does beside the step itself.
struct IterationPlan {
  StageSpan span;
  bool is_coarse = false;          // its views are at half their size
  int most_sh_degree = 0;          // active degree of the harmonics, as far as the model has it
  double lr_factor = 1;            // of all learning rates
  bool is_recorded = false;        // a row of the history is due after it
  bool observes = false;           // density control observes the gradients of its views
  bool densifies = false;          // clone, split and prune follow it
  bool resets_opacity = false;     // and a reset of opacities
  bool prunes_unseen = false;      // Gaussians that hardly any training view shows are removed
  bool lowers_sh_degrees = false;  // bands of the harmonics that gain too little are removed
  bool prunes = false;             // Gaussians that gain too little are removed
  double pruning_done = 0;         // fraction of the time for pruning that is over
};

class TrainingSchedule {
 public:
  // The options must outlive this object.
  explicit TrainingSchedule(const TrainOptions& options) : options_(options) {}

  const TrainOptions& options() const { return options_; }
  // Iterations of the stage, where no time limit ends it sooner.
  int iterations() const;
  IterationPlan At(const StageSpan& span) const;
  // Whether the parameters after that iteration count in their mean.
  bool Averages(const StageSpan& span, int iteration) const;

 private:
  const TrainOptions& options_;
};

}  // namespace vesta::gs
