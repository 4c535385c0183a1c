// SPDX-License-Identifier: Apache-2.0
// Density control: Gaussians with a large pull (density_steps.h) are split; transparent or huge Gaussians are pruned.
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

// Price of a Gaussian without SH bands by Akaike's criterion (KeepByAic, splatting/pruning/prune.h): the decrease of
// the summed loss over `epochs` passes through the training views that pays for its 14 parameters. loss: mean over
// unmasked pixels and channels, >= 0.
inline double GaussianPrice(double loss, double epochs) { return splat::NumAttributes(0) * loss * epochs; }

template <class Space>
class DensityControl {
 public:
  DensityControl(const DensityOptions& options, double extent) : options_(options), extent_(extent) {}

  // A second limit besides DensityOptions::max_gaussians.
  void LimitGaussians(Index most) { most_ = std::min(most_, most); }
  // Clears the statistics, for `count` Gaussians.
  void ResetStatistics(Index count) {
    pull_.Resize(count);
    views_ = 0;
  }

  // Gaussian i of the model was Gaussian source[i].
  void Reorder(const Buffer<std::uint32_t, Space>& source) { pull_ = GatherNumbers(pull_, source); }

  // Adds the statistics of one view, after its gradient was computed. Asynchronous on a device.
  void Observe(const density::PullView& view) {
    const ScopedPhase phase("density statistics");
    ForEach<Space>(pull_.size(), 4096, density::Observe{view, pull_.data()});
    CountViews(1);
  }
  // Counts views whose pulls the caller adds to pull().
  void CountViews(Index views) { views_ += views; }

  // Statistics since the last reset. pull(): sum of the pulls of each Gaussian over the observed views. views(): number
  // of observed views.
  Buffer<float, Space>& pull() { return pull_; }
  Index views() const { return views_; }

  // The action for each of the `count` Gaussians of the model x. Pruning is skipped if it would remove all. Growth
  // stops at the limits; Gaussians with the largest pulls grow first (ties: the lower index). price: GaussianPrice. On
  // a device, waits, and throws OutOfDeviceMemory if memory runs out.
  DensityPlan<Space> Decide(const float* x, Index count, double price) const;
  // Turns the copies in the new model x into halves.
  void InitChildren(const DensityPlan<Space>& plan, float* x) const {
    ForEach<Space>(plan.count, kGrain, density::InitChild{plan.count, plan.source.data(), plan.action.data(), x});
  }
  // Limits opacities to 0.01.
  static void LowerOpacities(float* x, Index count) {
    ForEach<Space>(count, kGrain, density::LowerLogit{x + splat::kOpacity * count});
  }

  // Whether the state from a checkpoint fits a model of this size.
  bool IsOf(Index count) const { return most_ > 0 && pull_.size() == count && views_ >= 0; }
  // The statistics and the limit set by LimitGaussians. Options may change on resuming.
  template <class Archive>
  void Visit(Archive& archive) {
    archive(most_, pull_, views_);
  }

 private:
  static constexpr Index kGrain = 4096;

  DensityOptions options_;
  Index most_ = std::numeric_limits<Index>::max();
  double extent_;
  Buffer<float, Space> pull_;
  Index views_ = 0;
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

// Lets only `room` of `candidates` Gaussians grow: sets the action of Gaussians with the smallest pulls to kKeep (ties:
// the higher index).
template <class Space>
void LimitToBudget(const Buffer<float, Space>& pull, Index candidates, Index room, DensifyAction* action) {
  Buffer<std::uint32_t, Space> keys, indices;
  keys.ResizeForOverwrite(pull.size());
  indices.ResizeForOverwrite(pull.size());
  ForEach<Space>(pull.size(), 4096, MakePullKey{pull.data(), action, keys.data(), indices.data()});
  Sorting<Space>::ByKey(keys, indices);
  ForEach<Space>(candidates - room, 4096, KeepAsItIs{indices.data() + room, action});
}

}  // namespace density

template <class Space>
DensityPlan<Space> DensityControl<Space>::Decide(const float* x, Index count, double price) const {
  VESTA_CHECK(pull_.size() == count, "density statistics of {} Gaussians for a model of {}", pull_.size(), count);
  VESTA_CHECK(count < Index{0xffffffff} / 2, "{} Gaussians", count);
  DensityPlan<Space> plan;
  plan.action.ResizeForOverwrite(count);
  density::ActionSums<Space> sums(count);
  ActionRule rule{.threshold = static_cast<float>(options_.grow_pull * price),
                  .prune_scale3d = static_cast<float>(options_.prune_scale3d * extent_),
                  .prune_opa = options_.prune_opa};
  const auto decide = [&] {
    ForEach<Space>(count, kGrain, density::DecideAction{rule, count, x, pull_.data(), plan.action.data()});
  };
  decide();
  Index kept = sums.Sum(plan.action, kSurvivors);
  if (kept == 0) {
    // An empty model cannot be trained.
    rule.prunes = false;
    decide();
    kept = count;
  }
  // Each candidate adds one Gaussian.
  Index candidates = sums.Sum(plan.action, kGrowing);
  const Index room = std::max<Index>(std::min(options_.max_gaussians, most_) - kept, 0);
  if (candidates > room) {
    density::LimitToBudget<Space>(pull_, candidates, room, plan.action.data());
    candidates = room;
  }
  plan.count = kept + candidates;
  plan.changes = kept < count || candidates > 0;
  if (!plan.changes) return plan;
  plan.source.ResizeForOverwrite(plan.count);
  plan.kept.ResizeForOverwrite(plan.count);
  sums.Sum(plan.action, kChildren);
  ForEach<Space>(count, kGrain,
                 density::PlaceChildren{plan.action.data(), sums.begin(), plan.source.data(), plan.kept.data()});
  return plan;
}

}  // namespace vesta::gs
