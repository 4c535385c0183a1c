// SPDX-License-Identifier: Apache-2.0
// Peak memory of a training run, predicted before it is asked for, and what is chosen to keep it within bounds.
#pragma once

#include <functional>
#include <limits>
#include <string>

#include "splatting/memory/stage_bytes.h"

namespace vesta::gs {

// The memory that the stages compute in: what each takes of it, and what there is.
struct StageMemory {
  double (*adam_bytes)(const MemoryScene&, const StageOptions&) = AdamBytes;
  double (*lm_bytes)(const MemoryScene&, const LmStageOptions&, bool hold_batches) = LmBytes;
  double (*joint_lm_bytes)(const MemoryScene&, const StageOptions&, bool eliminate_views) = JointLmBytes;
  double bytes = std::numeric_limits<double>::infinity();  // that the stages may take
  // Above this LM takes less where that costs nothing but time.
  double comfortable_bytes = std::numeric_limits<double>::infinity();
  // Whether LM holds its views where they fit, though asked to build them anew (JacobianKind::kOnTheFly).
  bool holds_views = false;
  // One line for the user: that `what` needs so many bytes, and what to do.
  std::function<std::string(const char* what, double needed)> refusal;
};
// memory.budget_gib less held_mib, which the process holds beside the stages. comfortable_bytes is three quarters of
// what the machine has free now, a share of them where several processes of one training run on it.
StageMemory HostMemory(const MemoryOptions& memory, double held_mib);
// Of a GPU with so many bytes free: most of them, and no more than memory.budget_gib.
StageMemory DeviceMemory(const MemoryOptions& memory, double free_bytes);

// How LM runs within the memory.
struct LmPlan {
  JacobianKind jacobian = JacobianKind::kCachedViews;
  bool hold_batches = true;
  bool eliminate_views = true;  // where it finds cameras too
  double bytes = 0;             // lm_bytes of that
};

// lm as it is where that fits, comfortably; else with the Jacobian recomputed; else with views rebuilt, which
// takes longer and changes no number; else of merged batches with one held at a time. Throws Error, one line that says
// how much would do, where one view at a time does not fit.
LmPlan PlanLm(const MemoryScene& scene, const LmStageOptions& lm, const StageMemory& memory);

// The same where LM finds cameras too: with views eliminated where that fits, comfortably, else solved for along.
// Throws Error where that does not fit.
LmPlan PlanJointLm(const MemoryScene& scene, const StageOptions& options, const StageMemory& memory);

// The most Gaussians, at most options.density.max_gaussians, of which both stages fit, LM at its most frugal. Throws
// Error where not even those that `scene` has do.
Index PlanGaussians(const MemoryScene& scene, const StageOptions& options, const StageMemory& memory);

// Most that the process holds in a run with these options beside what it held before: the larger of the stages.
// lm_bytes: of LmPlan, 0 without LM. Stages that compute on a GPU leave to the host the model, a copy of what was
// before the last growth where the GPU does not keep it, and evaluation where the GPU has no room for it.
double PredictedMib(const MemoryScene& scene, const StageOptions& options, double lm_bytes);
double PredictedMibBesideDevice(const MemoryScene& scene, const StageOptions& options);
// Most that the GPU holds. kept_bytes: of the copy of what was before the last growth, where that is kept there.
double PredictedDeviceMib(const MemoryScene& scene, const StageOptions& options, double lm_bytes,
                          double kept_bytes = 0);

}  // namespace vesta::gs
