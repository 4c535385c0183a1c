// SPDX-License-Identifier: Apache-2.0
// Predicts the peak memory of a training run, and chooses how LM runs and how many Gaussians fit.
#pragma once

#include <functional>
#include <limits>
#include <string>

#include "splatting/memory/stage_bytes.h"

namespace vesta::gs {

// The memory for the stages: functions that predict the use of each stage, and the limits.
struct StageMemory {
  double (*adam_bytes)(const MemoryScene&, const StageOptions&) = AdamBytes;
  double (*lm_bytes)(const MemoryScene&, const LmStageOptions&, bool hold_batches) = LmBytes;
  double (*joint_lm_bytes)(const MemoryScene&, const StageOptions&, bool eliminate_views) = JointLmBytes;
  double bytes = std::numeric_limits<double>::infinity();  // limit for the stages
  // Above this, LM saves memory where that only costs time.
  double comfortable_bytes = std::numeric_limits<double>::infinity();
  // Whether LM keeps its views if they fit, even with JacobianKind::kOnTheFly.
  bool holds_views = false;
  // Message for the user, in one line: `what` needs `needed` bytes, and what to do.
  std::function<std::string(const char* what, double needed)> refusal;
};
// The limit is memory.budget_gib minus held_mib, the memory that the process already holds. comfortable_bytes is three
// quarters of the free memory of the machine, divided by the number of processes of this training on it.
StageMemory HostMemory(const MemoryOptions& memory, double held_mib);
// For a GPU with this many free bytes: most of them, and at most memory.budget_gib.
StageMemory DeviceMemory(const MemoryOptions& memory, double free_bytes);

// How LM runs within the memory.
struct LmPlan {
  JacobianKind jacobian = JacobianKind::kCachedViews;
  bool hold_batches = true;
  bool eliminate_views = true;  // if LM also optimises cameras
  double bytes = 0;             // result of lm_bytes for this plan
};

// The first of these plans that fits: lm as given, or with cached views (both within comfortable_bytes too); with views
// rebuilt, which is slower but gives the same numbers; with one of several merged batches held at a time. Throws Error
// with the required memory, in one line, if none fits.
LmPlan PlanLm(const MemoryScene& scene, const LmStageOptions& lm, const StageMemory& memory);

// The same for LM that also optimises cameras. Views are eliminated if that fits (within comfortable_bytes too), else
// solved for jointly. Throws Error if neither fits.
LmPlan PlanJointLm(const MemoryScene& scene, const StageOptions& options, const StageMemory& memory);

// The largest number of Gaussians with which both stages fit, with LM in its most frugal form; at most
// options.density.max_gaussians. Throws Error if even the Gaussians of `scene` do not fit.
Index PlanGaussians(const MemoryScene& scene, const StageOptions& options, const StageMemory& memory);

// Peak memory of a run, beside the memory held before it: the maximum over the stages. lm_bytes: from LmPlan, 0 without
// LM. PredictedMibBesideDevice: host memory when the stages run on a GPU. It includes the model, scoring and
// evaluation, and a copy from before densification that the GPU may have no room for.
double PredictedMib(const MemoryScene& scene, const StageOptions& options, double lm_bytes);
double PredictedMibBesideDevice(const MemoryScene& scene, const StageOptions& options);
// Peak memory on the GPU. snapshot_bytes: the size of the copy from before densification, if it is on the GPU.
double PredictedDeviceMib(const MemoryScene& scene, const StageOptions& options, double lm_bytes,
                          double snapshot_bytes = 0);

}  // namespace vesta::gs
