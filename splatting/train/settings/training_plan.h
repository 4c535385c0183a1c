// SPDX-License-Identifier: Apache-2.0
// The plan of a training: what the program decides beside the options, and when the Adam stage does what.
#pragma once

#include "problems/gaussian_splatting/scene/scene.h"
#include "problems/gaussian_splatting/scene/stage_span.h"
#include "splatting/memory/memory_plan.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::gs {

// Iterations of Adam that this many training views require: 4,000, as long as each view has its turn 76 times, and
// else as many as that takes (docs/decisions/training-length.md).
double IterationsFor(Index training_views);

// The options with every std::optional filled in: iterations and degree of the harmonics. Under a time limit time alone
// ends the Adam stage, unless iterations are given. Throws Error where the options are not valid, or an iteration is to
// take more views than there are.
TrainOptions FitToScene(TrainOptions options, Index training_views);

// The decisions of one training. Its options never change.
struct ResolvedPlan {
  explicit ResolvedPlan(const TrainOptions& options) : max_gaussians(options.density.max_gaussians), lm(options.lm) {}

  double held_mib = 0;  // memory of the process beside the stages: the program, images, copies of cameras
  Index max_gaussians;  // density.max_gaussians, or fewer where memory is limited
  LmStageOptions lm;    // as the LM stage runs; 0 iterations: it does not
  LmPlan lm_memory;     // how it runs within the memory
};

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
