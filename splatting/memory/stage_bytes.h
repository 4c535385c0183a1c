// SPDX-License-Identifier: Apache-2.0
// The quantities and options that determine the memory of a training, and the peak bytes of each stage.
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

  // The same scene with another number of Gaussians; the counts per view change in proportion.
  MemoryScene Scaled(Index new_gaussians) const;
  // The same views with a model of another layout.
  MemoryScene Of(const splat::ModelLayout& other) const;
  // The maximum of each count over the views.
  ViewCounts Largest() const;
};

// Projects and bins at most `most` of the views, evenly spaced, and gives the others their mean. most >= 1.
// with_entries: also counts Jacobian entries, at the cost of rendering each of these views.
MemoryScene CountMemory(const splat::Model<float>& model, const std::vector<const View*>& views, double near, int most,
                        bool with_entries);

// Options of the memory limit.
struct MemoryOptions {
  double budget_gib = 0;  // limit of the process; 0: none
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

// Whether LM optimises cameras and exposures jointly with the Gaussians (train/lm_stage/lm_stage.h). After an Adam
// stage it does not, since Adam has optimised them.
inline bool FindsCamerasByLm(const StageOptions& options) {
  return options.lm.iterations > 0 && options.cameras.refines() && !options.adam.runs();
}

inline constexpr double kMib = 1 << 20;  // bytes

// A vector of all parameters.
double VectorBytes(const MemoryScene& scene);

// 32 bits per Gaussian.
double PerGaussianBytes(const MemoryScene& scene);

// The bases of Adam's blocks; 0 without blocks.
double BasesBytes(const MemoryScene& scene, const AdamOptions& options);

// The Gram matrices of all Gaussians.
double GramBytes(const MemoryScene& scene);

// Memory that passes over views use temporarily.
struct PassingBytes {
  double gram = 0;          // to measure Gram matrices
  double cost = 0;          // to compute the cost of a trial step
  double evaluation = 0;    // to compute the cost and quality of x between iterations
  bool keeps_gram = false;  // ProblemMemory::keeps_gram: the Gram matrices are kept
};

// Peak memory of the LM engine and the linearizations of its batches, including the model. views_bytes: of all
// linearized views. hold_batches: whether all linearizations of the batches are held at once. passing: temporary
// memory.
double EngineBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches, double views_bytes,
                   const PassingBytes& passing);

// Peak bytes of each stage of training, beside the scene's images and the program: the model, and everything that the
// stage allocates. These are formulas, so the sizes for a GPU need no GPU.
// In host memory:
double AdamBytes(const MemoryScene& scene, const StageOptions& options);
// Depends on lm's jacobian, preconditioner, batches and merge_batches. hold_batches: whether the linearizations of all
// batches are held at once.
double LmBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches);
// For LM that also optimises cameras (cameras/joint/joint_problem.h). Views are held, with their columns if eliminated.
double JointLmBytes(const MemoryScene& scene, const StageOptions& options, bool eliminate_views);
// The model and its evaluation, which exist between the stages.
double ModelBytes(const MemoryScene& scene);
// Scoring of Gaussians, on the host wherever the stages run; 0 if the options do not need it.
double ScoringBytes(const MemoryScene& scene, const PruningOptions& pruning);

// In GPU memory, including the photographs of all views.
double DeviceAdamBytes(const MemoryScene& scene, const StageOptions& options);
double DeviceLmBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches);
double DeviceJointLmBytes(const MemoryScene& scene, const StageOptions& options, bool eliminate_views);

}  // namespace vesta::gs
