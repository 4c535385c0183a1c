// Peak memory of a training run, predicted before it is asked for, and what is chosen to keep it within a budget.
#pragma once

#include <string>
#include <vector>

#include "problems/gaussian_splatting/io/ply.h"
#include "problems/gaussian_splatting/io/scene.h"
#include "problems/gaussian_splatting/train/options.h"

namespace vesta::gs {

// What a view of a model needs memory for.
struct ViewCounts {
  double pixels = 0, tiles = 0;
  double splats = 0;   // seen
  double pairs = 0;    // of splat and tile
  double entries = 0;  // of pixel and splat: those of a cached Jacobian
};

// A model and its views, for the sums below.
struct MemoryScene {
  Index gaussians = 0;
  int sh_degree = 3;
  std::vector<ViewCounts> views;

  // The same with another number of Gaussians, what it counts growing in proportion.
  MemoryScene Scaled(Index new_gaussians) const;
};

// Projects and bins at most `most` of the views, evenly spread, and gives the others their mean; counts entries where
// `with_entries` (then each takes as long as rendering, besides). most >= 1.
MemoryScene CountMemory(const SplatModel& model, const std::vector<const View*>& views, double near, int most,
                        bool with_entries);

// Bytes that each stage holds at its peak beside the scene's images and the program: the model, and all that the stage
// keeps.
double AdamBytes(const MemoryScene& scene, const TrainOptions& options);
// lm: jacobian, preconditioner, batches and merge_batches count. hold_batches: whether the linearizations of all
// batches are there at once.
double LmBytes(const MemoryScene& scene, const LmOptions& lm, bool hold_batches);

// How LM runs within the budget.
struct LmPlan {
  LmOptions lm;  // with jacobian, batches and merge_batches as chosen
  bool hold_batches = true;
  double bytes = 0;  // LmBytes of that
};

// options.lm as it is where that fits options.memory; else with the Jacobian recomputed; else in as few batches,
// merged, one held at a time, as fit. Throws Error, one line that says how much would do, where one view a batch does
// not fit.
LmPlan PlanLm(const MemoryScene& scene, const TrainOptions& options);

// The most Gaussians, at most options.density.max_gaussians, of which both stages fit the budget, LM at its most
// frugal. Throws Error where not even those that `scene` has do.
Index PlanGaussians(const MemoryScene& scene, const TrainOptions& options);

// Most that the process holds in a run with these options: what it held before, and the larger of the stages. lm_bytes:
// of LmPlan, 0 without LM.
double PredictedMib(const MemoryScene& scene, const TrainOptions& options, double lm_bytes);

}  // namespace vesta::gs
