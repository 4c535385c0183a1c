// SPDX-License-Identifier: Apache-2.0
// The plan of a training: values that the options leave open, and the schedule of the Adam stage.
#pragma once

#include "problems/gaussian_splatting/scene/scene.h"
#include "problems/gaussian_splatting/scene/stage_span.h"
#include "splatting/memory/memory_plan.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::gs {

// Default length of the Adam stage as a number of processed views: 76 times the number of training views, at least
// 4,000 (docs/decisions/training-length.md). An iteration processes batch_size views, so the number of iterations is
// this number divided by batch_size (NumIterations).
double IterationsFor(Index training_views);

// Fills in AdamOptions::iterations and sh_degree if empty. If there is a time limit but no number of iterations, only
// the limit ends the Adam stage. Throws Error if the options are invalid, or if batch_size exceeds the number of
// training views.
TrainOptions FitToScene(TrainOptions options, Index training_views);

// Values that the options leave open, chosen while a training runs.
struct ResolvedPlan {
  explicit ResolvedPlan(const TrainOptions& options) : max_gaussians(options.density.max_gaussians), lm(options.lm) {}

  // Memory in MiB that does not belong to a stage (memory_plan.h predicts the stages): the process with the scene,
  // before the training; photographs that are still to be loaded; copies of photographs for camera refinement.
  double held_mib = 0;
  Index max_gaussians;  // density.max_gaussians, or fewer if memory is limited
  // Options with which the LM stage runs. They may differ from TrainOptions::lm, for example if memory is limited. With
  // 0 iterations, the stage is skipped.
  LmStageOptions lm;
  LmPlan lm_memory;
};

// The events of an Adam iteration.
struct IterationPlan {
  StageSpan span;
  bool is_coarse = false;             // uses half-size views
  int max_sh_degree = 0;              // in use; the stage limits it to the model's
  double lr_factor = 1;               // on all learning rates
  bool is_recorded = false;           // adds a history row afterwards
  bool observes = false;              // density control collects pulls
  bool densifies = false;             // splits and prunes afterwards
  bool resets_opacity = false;        // resets opacities, even if it does not densify
  bool prunes_before_growth = false;  // removes Gaussians that improve the images too little, then densifies
  bool shrinks_unseen = false;        // shrinks Gaussians that lie mostly outside all training images
  bool lowers_sh_degrees = false;     // removes SH bands that improve the images too little
  bool prunes = false;                // removes Gaussians that improve the images too little
  double scoring_fraction = 0;        // fraction of the period with pruning that has passed
};

class TrainingSchedule {
 public:
  // The options must outlive this object.
  explicit TrainingSchedule(const TrainOptions& options) : options_(options) {}

  const TrainOptions& options() const { return options_; }
  // Length of the Adam stage, unless a time limit ends it earlier.
  int iterations() const;
  IterationPlan At(const StageSpan& span) const;
  // Whether the parameters after this iteration are added to their average (parameter_mean.h).
  bool Averages(const StageSpan& span, int iteration) const;

 private:
  const TrainOptions& options_;
};

}  // namespace vesta::gs
