// SPDX-License-Identifier: Apache-2.0
// What decides how much memory a training takes, and the bytes that each stage holds at its peak.
#pragma once

#include <vector>

#include "kernels/gaussian_splatting/formulas/types.h"
#include "problems/gaussian_splatting/lm/lm_stage_options.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/adam/adam_options.h"
#include "splatting/cameras/unknowns/view_unknowns.h"
#include "splatting/density/density_options.h"
#include "splatting/pruning/pruning_options.h"

namespace vesta::gs {

using splat::ViewCounts;

// Sizes of a model and its views, from which memory is foreseen.
struct MemoryScene {
  splat::ModelLayout layout;
  std::vector<ViewCounts> views;
  double mask_bytes = 0;  // of photographs of which not all takes part

  // The same with another number of Gaussians, what it counts growing in proportion.
  MemoryScene Scaled(Index new_gaussians) const;
  // The same views of a model with this layout.
  MemoryScene Of(const splat::ModelLayout& other) const;
  // The largest of each count over the views.
  ViewCounts Largest() const;
};

// Projects and bins at most `most` of the views, evenly spread, and gives the others their mean; counts entries where
// `with_entries` (then each takes as long as rendering, besides). most >= 1.
MemoryScene CountMemory(const splat::Model<float>& model, const std::vector<const View*>& views, double near, int most,
                        bool with_entries);

// What of a training's options decides how much memory it takes.
struct MemoryOptions {
  double budget_gib = 0;  // of the process; 0: none
};

const schema::Table<MemoryOptions>& MemoryFields();

struct StageOptions {
  MemoryOptions memory;
  AdamOptions adam;
  DensityOptions density;
  PruningOptions pruning;
  CameraOptions cameras;
  LmStageOptions lm;
};

// Whether LM solves for cameras and exposures along with the splats (train/lm_stage/lm_stage.h): after an Adam
// stage, which finds them, it does not.
inline bool FindsCamerasByLm(const StageOptions& options) {
  return options.lm.iterations > 0 && options.cameras.refines() && !options.adam.runs();
}

inline constexpr double kMib = 1 << 20;  // bytes

// One vector of parameters.
double VectorBytes(const MemoryScene& scene);

// A number of 32 bits for each Gaussian.
double PerGaussianBytes(const MemoryScene& scene);

// The bases of Adam's blocks, where it has them.
double BasesBytes(const MemoryScene& scene, const AdamOptions& options);

// Of the Gram matrices of all Gaussians.
double GramBytes(const MemoryScene& scene);

// What passes over views work in and give back.
struct PassingBytes {
  double gram = 0;          // measuring Gram matrices
  double cost = 0;          // the cost of a trial
  double evaluation = 0;    // that of x, and its quality, between iterations
  bool keeps_gram = false;  // ProblemMemory::keeps_gram: the matrices themselves stay
};

// What the engine of LM and the linearizations of its batches hold at the peak, model included. views_bytes: of all
// linearized views together. hold_batches: whether the linearizations of all batches are there at once. passing: what
// is there for a while only.
double EngineBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches, double views_bytes,
                   const PassingBytes& passing);

// Bytes that each stage of training holds at its peak, beside the scene's images and the program: the model, and all
// that the stage keeps. Sums alone: no GPU is needed for those of one.
// In the memory of the host.
double AdamBytes(const MemoryScene& scene, const StageOptions& options);
// lm: jacobian, preconditioner, batches and merge_batches count. hold_batches: whether the linearizations of all
// batches are there at once.
double LmBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches);
// Where LM finds cameras too (cameras/joint/joint_problem.h): views are held, with their columns where they are
// eliminated.
double JointLmBytes(const MemoryScene& scene, const StageOptions& options, bool eliminate_views);
// The model and what evaluating it needs: all there is between the stages.
double ModelBytes(const MemoryScene& scene);
// What judging Gaussians takes on the host beside the model, wherever the stages are; 0 where options ask for none.
double ScoringBytes(const MemoryScene& scene, const PruningOptions& pruning);

// In that of a GPU, with the truths of all views.
double DeviceAdamBytes(const MemoryScene& scene, const StageOptions& options);
double DeviceLmBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches);
double DeviceJointLmBytes(const MemoryScene& scene, const StageOptions& options, bool eliminate_views);

}  // namespace vesta::gs
