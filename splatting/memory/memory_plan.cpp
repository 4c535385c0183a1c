// SPDX-License-Identifier: Apache-2.0
#include "splatting/memory/memory_plan.h"

#include <fmt/format.h>

#include <algorithm>

#include "kernels/core/error.h"
#include "kernels/core/process_memory.h"
#include "kernels/ranks/communicator.h"
#include "splatting/memory/stage_bytes.h"

namespace vesta::gs {
namespace {

constexpr double kGib = 1 << 30;
// The rest allows for fragmentation of the pool, code and kernel stacks.
constexpr double kUsableShare = 15.0 / 16;

// Rounded up to two decimals.
double RoundedGib(double bytes) { return bytes / kGib + 0.005; }

double StageMib(double adam, double lm, double between) { return std::max({adam, lm, between}) / kMib; }

bool MayHoldOneBatch(const LmStageOptions& lm) { return lm.batches > 1 && lm.merge_batches; }

// Each view is rebuilt when needed, and one of several merged batches is held at a time.
double FrugalLmBytes(const MemoryScene& scene, LmStageOptions lm, const StageMemory& memory) {
  lm.jacobian = JacobianKind::kOnTheFly;
  return memory.lm_bytes(scene, lm, !MayHoldOneBatch(lm));
}

}  // namespace

StageMemory HostMemory(const MemoryOptions& memory, double held_mib) {
  StageMemory result;
  const double before = held_mib * kMib;
  if (memory.budget_gib > 0) result.bytes = memory.budget_gib * kGib - before;
  result.comfortable_bytes = 0.75 * AvailableMemoryMib() * kMib / NumRanksOnThisMachine();
  result.refusal = [memory, before](const char* what, double needed) {
    return fmt::format(
        "--memory_budget={}: {} needs {:.2f} GiB, including {:.2f} for program and images; increase the budget, or use "
        "--downscale or fewer Gaussians",
        memory.budget_gib, what, RoundedGib(needed + before), before / kGib);
  };
  return result;
}

StageMemory DeviceMemory(const MemoryOptions& memory, double free_bytes) {
  StageMemory result;
  result.adam_bytes = DeviceAdamBytes;
  result.lm_bytes = DeviceLmBytes;
  result.joint_lm_bytes = DeviceJointLmBytes;
  result.holds_views = true;
  result.bytes = kUsableShare * free_bytes;
  const bool by_flag = memory.budget_gib > 0 && memory.budget_gib * kGib <= result.bytes;
  if (by_flag) result.bytes = memory.budget_gib * kGib;
  result.refusal = [memory, by_flag, usable = result.bytes](const char* what, double needed) {
    return by_flag ? fmt::format(
                         "--memory_budget={}: {} needs {:.2f} GiB of the GPU; increase the budget, or use "
                         "--device=cpu, --downscale or fewer Gaussians",
                         memory.budget_gib, what, RoundedGib(needed))
                   : fmt::format(
                         "{} needs {:.2f} GiB of the GPU, but {:.2f} are available; use --device=cpu, "
                         "--downscale or fewer Gaussians",
                         what, RoundedGib(needed), usable / kGib);
  };
  return result;
}

LmPlan PlanLm(const MemoryScene& scene, const LmStageOptions& lm, const StageMemory& memory) {
  LmPlan plan;
  LmStageOptions tried = lm;
  const auto takes = [&](JacobianKind jacobian, bool hold_batches, double room) {
    plan.jacobian = tried.jacobian = jacobian, plan.hold_batches = hold_batches;
    plan.bytes = memory.lm_bytes(scene, tried, hold_batches);
    return plan.bytes <= room;
  };
  const double fits = std::min(memory.bytes, memory.comfortable_bytes);
  const bool holds = lm.jacobian == JacobianKind::kOnTheFly && memory.holds_views;
  if (takes(holds ? JacobianKind::kCachedViews : lm.jacobian, true, fits) || lm.iterations == 0) return plan;
  if (takes(JacobianKind::kCachedViews, true, fits) || takes(JacobianKind::kOnTheFly, true, memory.bytes)) return plan;
  if (MayHoldOneBatch(lm) && takes(JacobianKind::kOnTheFly, false, memory.bytes)) return plan;
  throw Error(kOutOfMemory, memory.refusal("LM with one view at a time", plan.bytes));
}

LmPlan PlanJointLm(const MemoryScene& scene, const StageOptions& options, const StageMemory& memory) {
  LmPlan plan;
  const auto takes = [&](bool eliminate_views, double room) {
    plan.eliminate_views = eliminate_views;
    plan.bytes = memory.joint_lm_bytes(scene, options, eliminate_views);
    return plan.bytes <= room;
  };
  if (takes(true, std::min(memory.bytes, memory.comfortable_bytes)) || takes(false, memory.bytes)) return plan;
  throw Error(kOutOfMemory, memory.refusal("LM with cameras", plan.bytes));
}

Index PlanGaussians(const MemoryScene& scene, const StageOptions& options, const StageMemory& memory) {
  const bool density = options.density.enabled && options.adam.runs();
  const Index most = density ? std::max(options.density.max_gaussians, scene.layout.count) : scene.layout.count;
  const auto bytes_of = [&](Index gaussians) {
    const MemoryScene scaled = scene.Scaled(gaussians);
    const double adam = options.adam.runs() ? memory.adam_bytes(scaled, options) : 0;
    if (FindsCamerasByLm(options)) return std::max(adam, memory.joint_lm_bytes(scaled, options, false));
    return std::max(adam, options.lm.iterations > 0 ? FrugalLmBytes(scaled, options.lm, memory) : 0.0);
  };
  if (bytes_of(scene.layout.count) > memory.bytes) {
    throw Error(kOutOfMemory, memory.refusal("this scene", bytes_of(scene.layout.count)));
  }
  Index fits = scene.layout.count, too_many = most + 1;
  while (too_many - fits > 1) {
    const Index middle = fits + (too_many - fits) / 2;
    (bytes_of(middle) <= memory.bytes ? fits : too_many) = middle;
  }
  return fits;
}

double PredictedMib(const MemoryScene& scene, const StageOptions& options, double lm_bytes) {
  const double adam = options.adam.runs() ? AdamBytes(scene, options) : 0;
  return StageMib(adam, lm_bytes, ModelBytes(scene));
}

double PredictedMibBesideDevice(const MemoryScene& scene, const StageOptions& options) {
  // A copy of parameters, moments and bases, if the GPU has no space for the new ones.
  const bool grows = options.adam.runs() && options.density.enabled;
  const double copies = grows ? 3 * VectorBytes(scene) + BasesBytes(scene, options.adam) : 0;
  return (std::max(ModelBytes(scene), ScoringBytes(scene, options.pruning)) + copies) / kMib;
}

double PredictedDeviceMib(const MemoryScene& scene, const StageOptions& options, double lm_bytes,
                          double snapshot_bytes) {
  const double adam = options.adam.runs() ? DeviceAdamBytes(scene, options) + snapshot_bytes : 0;
  return StageMib(adam, lm_bytes, 0);
}

}  // namespace vesta::gs
