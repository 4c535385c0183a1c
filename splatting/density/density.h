// SPDX-License-Identifier: Apache-2.0
// Adaptive density control (Kerbl et al. 2023, section 5.2). Gaussians with a large image-space gradient are cloned if
// small and split if large; transparent or huge Gaussians are pruned.
#pragma once

#include <algorithm>
#include <limits>

#include "kernels/core/check.h"
#include "kernels/core/profile.h"
#include "kernels/core/sort.h"
#include "kernels/core/vector_backend.h"
#include "problems/gaussian_splatting/model/gather_rows.h"
#include "splatting/density/density_steps.h"

namespace vesta::gs {

// A change of the model. Gaussian i of the new model starts as a copy of Gaussian source[i] of the old one. It keeps
// Adam's moments if kept[i] is 1; if 0, they become zero.
template <class Space>
struct DensityPlan {
  Buffer<std::uint32_t, Space> source;
  Buffer<std::uint8_t, Space> kept;
  Buffer<DensifyAction, Space> action;  // by Gaussian of the old model
  Index count = 0;                      // Gaussians of the new model
  bool changes = false;                 // false: source and kept are empty
};

template <class Space>
class DensityControl {
 public:
  DensityControl(const DensityOptions& options, double extent, std::uint64_t seed)
      : options_(options), extent_(extent), seed_(seed) {}

  // A second limit besides DensityOptions::max_gaussians.
  void LimitGaussians(Index most) { most_ = std::min(most_, most); }
  // Clears the statistics, for `count` Gaussians.
  void ResetStatistics(Index count) {
    grad2d_sum_.Resize(count);
    seen_.Resize(count);
  }

  // Gaussian i of the model was Gaussian source[i].
  void Reorder(const Buffer<std::uint32_t, Space>& source) {
    grad2d_sum_ = GatherNumbers(grad2d_sum_, source);
    seen_ = GatherNumbers(seen_, source);
  }

  // Adds the statistics of one view. grad2d_view: from Grad2dOf, after the gradient of the view was computed.
  // Asynchronous on a device.
  void Observe(const density::Grad2dView& grad2d_view) {
    const ScopedPhase phase("density statistics");
    ForEach<Space>(grad2d_sum_.size(), 4096, density::Observe{grad2d_view, grad2d_sum_.data(), seen_.data()});
  }

  // Statistics per Gaussian over the views that saw it since the last reset. grad2d(): sum of the norms of the
  // derivative of the loss by the projected mean (Grad2d, density_steps.h). seen(): number of these views.
  Buffer<float, Space>& grad2d() { return grad2d_sum_; }
  Buffer<int, Space>& seen() { return seen_; }

  // The action for each of the `count` Gaussians of the model x. Pruning is skipped if it would remove all. Growth
  // stops at the limits; Gaussians with the largest mean gradients grow first (ties: the lower index). On a device,
  // waits, and throws OutOfDeviceMemory if memory runs out.
  DensityPlan<Space> Decide(const float* x, Index count) const;
  // Turns the copies in the new model x into clones and splits. iteration and the seed determine the random offsets.
  void InitChildren(const DensityPlan<Space>& plan, int iteration, float* x) const {
    ForEach<Space>(plan.count, kGrain,
                   density::InitChild{plan.count, plan.source.data(), plan.action.data(), seed_, iteration, x});
  }
  // Limits opacities to 0.01.
  static void LowerOpacities(float* x, Index count) {
    ForEach<Space>(count, kGrain, density::LowerLogit{x + splat::kOpacity * count});
  }

  // Whether the state from a checkpoint fits a model of this size.
  bool IsOf(Index count) const { return most_ > 0 && grad2d_sum_.size() == count && seen_.size() == count; }
  // The statistics and the limit set by LimitGaussians. Options may change on resuming.
  template <class Archive>
  void Visit(Archive& archive) {
    archive(most_, grad2d_sum_, seen_);
  }

 private:
  static constexpr Index kGrain = 4096;

  DensityOptions options_;
  Index most_ = std::numeric_limits<Index>::max();
  double extent_;
  std::uint64_t seed_;
  Buffer<float, Space> grad2d_sum_;
  Buffer<int, Space> seen_;
};

namespace density {

// Sums of DensifyNumbers.
template <class Space>
class ActionSums {
 public:
  explicit ActionSums(Index count) : count_(count), counts_(count + 1), begin_(count + 1) {}

  // begin()[i] becomes the sum over the Gaussians before i.
  Index Sum(const Buffer<DensifyAction, Space>& action, const DensifyNumbers& numbers) {
    ForEach<Space>(count_ + 1, 4096, CountActions{count_, action.data(), numbers, counts_.data()});
    return Sorting<Space>::RunningSum(counts_, begin_);
  }
  const Index* begin() const { return begin_.data(); }

 private:
  Index count_;
  Buffer<Index, Space> counts_, begin_;
};

// Lets only `room` of `candidates` Gaussians grow: sets the action of Gaussians with the smallest mean gradients to
// kKeep (ties: the higher index).
template <class Space>
void LimitToBudget(const Observed& observed, Index candidates, Index room, DensifyAction* action) {
  Buffer<std::uint32_t, Space> keys, indices;
  keys.ResizeForOverwrite(observed.count);
  indices.ResizeForOverwrite(observed.count);
  ForEach<Space>(observed.count, 4096, MakeStrengthKey{observed, action, keys.data(), indices.data()});
  Sorting<Space>::ByKey(keys, indices);
  ForEach<Space>(candidates - room, 4096, KeepAsItIs{indices.data() + room, action});
}

}  // namespace density

template <class Space>
DensityPlan<Space> DensityControl<Space>::Decide(const float* x, Index count) const {
  VESTA_CHECK(grad2d_sum_.size() == count, "density statistics of {} Gaussians for a model of {}", grad2d_sum_.size(),
              count);
  VESTA_CHECK(count < Index{0xffffffff} / 2, "{} Gaussians", count);
  const density::Observed observed{count, x, grad2d_sum_.data(), seen_.data()};
  DensityPlan<Space> plan;
  plan.action.ResizeForOverwrite(count);
  density::ActionSums<Space> sums(count);
  ActionRule rule(options_, extent_);
  ForEach<Space>(count, kGrain, density::DecideAction{rule, observed, plan.action.data()});
  Index kept = sums.Sum(plan.action, kSurvivors);
  if (kept == 0) {
    // An empty model cannot be trained.
    rule.prunes = false;
    ForEach<Space>(count, kGrain, density::DecideAction{rule, observed, plan.action.data()});
    kept = count;
  }
  // Each candidate adds one Gaussian.
  Index candidates = sums.Sum(plan.action, kGrowing);
  const Index room = std::max<Index>(std::min(options_.max_gaussians, most_) - kept, 0);
  if (candidates > room) {
    density::LimitToBudget<Space>(observed, candidates, room, plan.action.data());
    candidates = room;
  }
  plan.count = kept + candidates;
  plan.changes = kept < count || candidates > 0;
  if (!plan.changes) return plan;
  plan.source.ResizeForOverwrite(plan.count);
  plan.kept.ResizeForOverwrite(plan.count);
  sums.Sum(plan.action, kChildren);
  ForEach<Space>(
      count, kGrain,
      density::PlaceChildren{kKeepingMoments, plan.action.data(), sums.begin(), plan.source.data(), plan.kept.data()});
  return plan;
}

}  // namespace vesta::gs
