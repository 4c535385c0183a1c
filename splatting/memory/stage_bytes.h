// SPDX-License-Identifier: Apache-2.0
// Sizes and options that determine the memory of a training, and the peak bytes of each stage.
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

// Sizes of a model and its views, from which memory is predicted.
struct MemoryScene {
  splat::ModelLayout layout;
  std::vector<ViewCounts> views;
  double mask_bytes = 0;  // masks of photographs

  // Counts per view change in proportion to the number of Gaussians.
  MemoryScene Scaled(Index new_gaussians) const;
  MemoryScene Of(const splat::ModelLayout& other) const;
  // Maximum over the views of each count except `entries`, which stays 0.
  ViewCounts Largest() const;
};

// Counts splats and tile entries in at most `most` >= 1 of the views, evenly spaced; the other views get the mean.
// near: distance of the near plane. with_entries: also renders these views to count the entries of the cached Jacobian.
MemoryScene CountMemory(const splat::Model<float>& model, const std::vector<const View*>& views, double near, int most,
                        bool with_entries);

struct MemoryOptions {
  double budget_gib = 0;  // of the process; 0: no limit
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

// Whether the LM stage optimises cameras and exposures jointly with the Gaussians (train/lm_stage/lm_stage.h). If there
// is an Adam stage, it has done this.
inline bool FindsCamerasByLm(const StageOptions& options) {
  return options.lm.iterations > 0 && options.cameras.refines() && !options.adam.runs();
}

inline constexpr double kMib = 1 << 20;  // bytes

// Bytes of a vector with all parameters of the model.
double VectorBytes(const MemoryScene& scene);

// Bytes of an array with a 32-bit number per Gaussian.
double PerGaussianBytes(const MemoryScene& scene);

// Bytes of Adam's bases in block mode (adam/block_bases.h); else 0.
double BasesBytes(const MemoryScene& scene, const AdamOptions& options);

// Bytes of the Gram matrices (blocks of J^T W J) of all Gaussians.
double GramBytes(const MemoryScene& scene);

// Temporary memory of passes over views, bytes.
struct PassingBytes {
  double gram = 0;          // to compute Gram matrices
  double cost = 0;          // for the cost of a trial step
  double evaluation = 0;    // for the cost and quality of x between iterations
  bool keeps_gram = false;  // see ProblemMemory
};

// Peak bytes of the LM solver and its linearizations, including the model. views_bytes: sum over the linearizations of
// all views. hold_batches: the linearizations of all batches are in memory at once. passing: temporary memory.
double EngineBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches, double views_bytes,
                   const PassingBytes& passing);

// Peak bytes of each stage: the model and the stage's allocations, without the scene's images and the program. The GPU
// functions need no GPU.
// In host memory:
double AdamBytes(const MemoryScene& scene, const StageOptions& options);
// hold_batches: see EngineBytes.
double LmBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches);
// LM that also optimises cameras (cameras/joint/joint_problem.h) caches all views. eliminate_views: stores the
// derivatives of views by their own unknowns too.
double JointLmBytes(const MemoryScene& scene, const StageOptions& options, bool eliminate_views);
// The model and its evaluation, between the stages.
double ModelBytes(const MemoryScene& scene);
// Scoring for pruning, on the host even if the stages run on a GPU. 0 if the options need no scores.
double ScoringBytes(const MemoryScene& scene, const PruningOptions& pruning);

// In GPU memory, including the photographs of all views.
double DeviceAdamBytes(const MemoryScene& scene, const StageOptions& options);
double DeviceLmBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches);
double DeviceJointLmBytes(const MemoryScene& scene, const StageOptions& options, bool eliminate_views);

}  // namespace vesta::gs
