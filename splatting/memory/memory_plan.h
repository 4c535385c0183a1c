// SPDX-License-Identifier: Apache-2.0
// Predicts the peak memory of a training, and chooses the form of the LM stage and the number of Gaussians that fit.
#pragma once

#include <functional>
#include <limits>
#include <string>

#include "splatting/memory/stage_bytes.h"

namespace vesta::gs {

// The memory in which the stages run, host or GPU: functions that predict the peak bytes of each stage there
// (stage_bytes.h), and limits.
struct StageMemory {
  double (*adam_bytes)(const MemoryScene&, const StageOptions&) = AdamBytes;
  double (*lm_bytes)(const MemoryScene&, const LmStageOptions&, bool hold_batches) = LmBytes;
  double (*joint_lm_bytes)(const MemoryScene&, const StageOptions&, bool eliminate_views) = JointLmBytes;
  double bytes = std::numeric_limits<double>::infinity();  // limit for the stages
  // If LM needs more than this, a form that needs less memory but more time is chosen.
  double comfortable_bytes = std::numeric_limits<double>::infinity();
  // Whether LM caches its views if they fit, even with JacobianKind::kOnTheFly.
  bool holds_views = false;
  // Returns the error message, in one line, that `what` needs `needed` bytes, and what to do.
  std::function<std::string(const char* what, double needed)> refusal;
};
// Limits in host memory. `bytes` is memory.budget_gib minus held_mib, which is the memory that the process already
// uses. comfortable_bytes is three quarters of the free memory of the machine, divided by the number of processes of
// this training on it.
StageMemory HostMemory(const MemoryOptions& memory, double held_mib);
// Limits on a GPU. `bytes` is 15/16 of its free_bytes, but at most memory.budget_gib.
StageMemory DeviceMemory(const MemoryOptions& memory, double free_bytes);

// The form in which LM runs, so that it fits into the memory.
struct LmPlan {
  JacobianKind jacobian = JacobianKind::kCachedViews;
  bool hold_batches = true;     // the linearizations of all batches are in memory at once
  bool eliminate_views = true;  // if LM also optimises cameras: PCG solves the system without the views
  double bytes = 0;             // predicted peak of the LM stage
};

// Chooses the first of these forms of LM that fits: (1) the Jacobian as in `lm`; (2) cached views; (3) views rebuilt
// when needed, which is slower but gives the same numbers; (4) views rebuilt and, if `lm` merges several batches, one
// batch in memory at a time. (1) and (2) must also fit into comfortable_bytes. Throws Error with the required memory,
// in one line, if even the last does not fit.
LmPlan PlanLm(const MemoryScene& scene, const LmStageOptions& lm, const StageMemory& memory);

// The same for LM that also optimises cameras. The views are eliminated if that fits, also into comfortable_bytes; else
// PCG solves for Gaussians and views together. Throws Error if neither fits.
LmPlan PlanJointLm(const MemoryScene& scene, const StageOptions& options, const StageMemory& memory);

// The largest number of Gaussians with which both stages fit, with LM in the form that needs the least memory. It is at
// most options.density.max_gaussians or, if larger, the number in `scene`. Throws Error if that number does not fit.
Index PlanGaussians(const MemoryScene& scene, const StageOptions& options, const StageMemory& memory);

// Predicted peak of host memory in MiB, beyond the memory used before the training: the maximum over the stages.
// lm_bytes: LmPlan::bytes, 0 without LM. PredictedMibBesideDevice: the same if the stages run on a GPU. It includes the
// model, scoring, evaluation, and a snapshot from before densification, which is on the host if the GPU has no room for
// it.
double PredictedMib(const MemoryScene& scene, const StageOptions& options, double lm_bytes);
double PredictedMibBesideDevice(const MemoryScene& scene, const StageOptions& options);
// Predicted peak of GPU memory in MiB. snapshot_bytes: size of the snapshot from before densification
// (rollback_point.h), if it is on the GPU; else 0.
double PredictedDeviceMib(const MemoryScene& scene, const StageOptions& options, double lm_bytes,
                          double snapshot_bytes = 0);

}  // namespace vesta::gs
