// SPDX-License-Identifier: Apache-2.0
// Predicts the peak memory of a training. Chooses the form of the LM stage and the number of Gaussians that fit.
#pragma once

#include <functional>
#include <limits>
#include <string>

#include "splatting/memory/stage_bytes.h"

namespace vesta::gs {

// The memory of the stages, host or GPU: functions that predict the peak bytes of each stage (stage_bytes.h), and
// limits.
struct StageMemory {
  double (*adam_bytes)(const MemoryScene&, const StageOptions&) = AdamBytes;
  double (*lm_bytes)(const MemoryScene&, const LmStageOptions&, bool hold_batches) = LmBytes;
  double (*joint_lm_bytes)(const MemoryScene&, const StageOptions&, bool eliminate_views) = JointLmBytes;
  double bytes = std::numeric_limits<double>::infinity();  // limit for the stages
  // If LM needs more than this limit, a slower form that needs less memory is chosen.
  double comfortable_bytes = std::numeric_limits<double>::infinity();
  // Whether LM caches its views if they fit, even with JacobianKind::kOnTheFly.
  bool holds_views = false;
  // The error message, in one line, that `what` needs `needed` bytes, and what to do.
  std::function<std::string(const char* what, double needed)> refusal;
};
// Limits in host memory. `bytes` is memory.budget_gib minus held_mib, the memory in use already. comfortable_bytes is
// three quarters of the machine's free memory, divided by the number of this training's processes on the machine.
StageMemory HostMemory(const MemoryOptions& memory, double held_mib);
// Limits on a GPU. `bytes` is 15/16 of its free_bytes, but at most memory.budget_gib.
StageMemory DeviceMemory(const MemoryOptions& memory, double free_bytes);

struct LmPlan {
  JacobianKind jacobian = JacobianKind::kCachedViews;
  bool hold_batches = true;     // the linearizations of all batches are in memory at once
  bool eliminate_views = true;  // if LM also optimises cameras: PCG solves the system without the views
  double bytes = 0;             // predicted peak of the LM stage
};

// The first of these forms of LM that fits: (1) the Jacobian as in `lm`; (2) cached views; (3) views rebuilt when
// needed, which is slower but gives the same numbers; (4) like (3) and, if `lm` merges several batches, one batch in
// memory at a time. (1) and (2) must also fit into comfortable_bytes. Throws Error with the required memory if none
// fits.
LmPlan PlanLm(const MemoryScene& scene, const LmStageOptions& lm, const StageMemory& memory);

// For LM that also optimises cameras. The views are eliminated if that fits into both limits of `memory`; else PCG
// solves for Gaussians and views together. Throws Error if neither fits.
LmPlan PlanJointLm(const MemoryScene& scene, const StageOptions& options, const StageMemory& memory);

// The largest number of Gaussians with which both stages fit, if LM has its smallest form. It is between the number in
// `scene` and options.density.max_gaussians. Throws Error if the number in `scene` does not fit.
Index PlanGaussians(const MemoryScene& scene, const StageOptions& options, const StageMemory& memory);

// Predicted peak of host memory in MiB, beyond the memory used before the training: the maximum over the stages.
// lm_bytes: LmPlan::bytes, 0 without LM. PredictedMibBesideDevice: if the stages run on a GPU; includes the model,
// scoring, evaluation, and a snapshot from before densification for which the GPU may have no space.
double PredictedMib(const MemoryScene& scene, const StageOptions& options, double lm_bytes);
double PredictedMibBesideDevice(const MemoryScene& scene, const StageOptions& options);
// Predicted peak of GPU memory in MiB. snapshot_bytes: snapshot from before densification (rollback_point.h), if it is
// on the GPU; else 0.
double PredictedDeviceMib(const MemoryScene& scene, const StageOptions& options, double lm_bytes,
                          double snapshot_bytes = 0);

}  // namespace vesta::gs
