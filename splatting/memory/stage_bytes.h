// SPDX-License-Identifier: Apache-2.0
// The sizes and options that determine the memory of a training, and formulas for the peak bytes of each stage.
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
  // The maximum over the views of each count except `entries`, which stays 0.
  ViewCounts Largest() const;
};

// Counts splats and tile entries in at most `most` of the views, evenly spaced; the other views get the mean of these
// counts. most >= 1. near: distance of the near plane. with_entries: also counts the entries of the cached Jacobian,
// for which each of these views is rendered.
MemoryScene CountMemory(const splat::Model<float>& model, const std::vector<const View*>& views, double near, int most,
                        bool with_entries);

// Options of the memory limit.
struct MemoryOptions {
  double budget_gib = 0;  // limit of the process; 0: none
};

const schema::Table<MemoryOptions>& MemoryFields();

// The options of both stages.
struct StageOptions {
  MemoryOptions memory;
  AdamOptions adam;
  DensityOptions density;
  PruningOptions pruning;
  CameraOptions cameras;
  LmStageOptions lm;
};

// Whether the LM stage optimises cameras and exposures jointly with the Gaussians (train/lm_stage/lm_stage.h). It does
// not after an Adam stage, which has already optimised them.
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

// Bytes that passes over views use temporarily.
struct PassingBytes {
  double gram = 0;          // to compute Gram matrices
  double cost = 0;          // to compute the cost of a trial step
  double evaluation = 0;    // to compute the cost and quality of x between iterations
  bool keeps_gram = false;  // ProblemMemory::keeps_gram: the Gram matrices are kept
};

// Peak bytes of the LM solver and the linearizations of its batches, including the model. views_bytes: sum over the
// linearizations of all views. hold_batches: whether the linearizations of all batches are in memory at once. passing:
// temporary memory.
double EngineBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches, double views_bytes,
                   const PassingBytes& passing);

// Peak bytes of each stage of training: the model, and everything that the stage allocates, but not the scene's images
// and the program. The GPU functions need no GPU.
// In host memory:
double AdamBytes(const MemoryScene& scene, const StageOptions& options);
// hold_batches: see EngineBytes.
double LmBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches);
// For LM that also optimises cameras (cameras/joint/joint_problem.h). All views are cached. eliminate_views: their
// derivatives with respect to their own unknowns are stored too.
double JointLmBytes(const MemoryScene& scene, const StageOptions& options, bool eliminate_views);
// The model and its evaluation, between the stages.
double ModelBytes(const MemoryScene& scene);
// Scoring of Gaussians for pruning. It runs on the host, even if the stages run on a GPU. 0 if the options need no
// scores.
double ScoringBytes(const MemoryScene& scene, const PruningOptions& pruning);

// In GPU memory, including the photographs of all views.
double DeviceAdamBytes(const MemoryScene& scene, const StageOptions& options);
double DeviceLmBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches);
double DeviceJointLmBytes(const MemoryScene& scene, const StageOptions& options, bool eliminate_views);

}  // namespace vesta::gs
