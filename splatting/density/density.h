// SPDX-License-Identifier: Apache-2.0
// Adaptive density control: where the images pull a Gaussian's mean about, clone it if small and split it if large;
// drop what is transparent or huge (Kerbl et al. 2023, section 5.2). For every memory space.
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

// How a model is to change: Gaussian i of the new one is first a copy of source[i] of the old one, with its moments
// where kept[i].
template <class Space>
struct DensityPlan {
  Buffer<std::uint32_t, Space> source;
  Buffer<std::uint8_t, Space> kept;
  Buffer<DensifyAction, Space> fate;  // by Gaussian of the old model
  Index count = 0;
  bool changes = false;  // without, source is empty: the model stays as it is
};

template <class Space>
class DensityControl {
 public:
  DensityControl(const DensityOptions& options, double extent, std::uint64_t seed)
      : options_(options), extent_(extent), seed_(seed) {}

  // From now on at most so many, where the options allow more.
  void LimitGaussians(Index most) { most_ = std::min(most_, most); }
  // Of a model of so many Gaussians from now on, of which nothing was observed.
  void Forget(Index count) {
    pull_.Resize(count);
    seen_.Resize(count);
  }

  // Gaussian i is now what source[i] was, and nothing else has changed.
  void Reorder(const Buffer<std::uint32_t, Space>& source) {
    pull_ = GatherNumbers(pull_, source);
    seen_ = GatherNumbers(seen_, source);
  }

  // Adds what one view, after its gradient, tells of where Gaussians are missing. pulls: Grad2dOf that view. On a
  // device it does not wait.
  void Observe(const density::Grad2dView& pulls) {
    const ScopedPhase phase("density statistics");
    ForEach<Space>(pull_.size(), 4096, density::Observe{pulls, pull_.data(), seen_.data()});
  }

  // What was observed, by Gaussian: the sum of |d loss / d mean| in normalised device coordinates over the
  // observations, and their number.
  Buffer<float, Space>& pull() { return pull_; }
  Buffer<int, Space>& seen() { return seen_; }

  // What is to become of the model x of `count` Gaussians. Never makes more than max_gaussians (the strongest
  // candidates come first, of two alike the earlier) and never none. On a device it waits some times, for numbers of
  // Gaussians, and throws OutOfDeviceMemory.
  DensityPlan<Space> Decide(const float* x, Index count) const;
  // Makes clones and splits of what are copies so far. x: of the new model; iteration: keys the random offsets.
  void Renew(const DensityPlan<Space>& plan, int iteration, float* x) const {
    ForEach<Space>(plan.count, kGrain,
                   density::InitChild{plan.count, plan.source.data(), plan.fate.data(), seed_, iteration, x});
  }
  // Opacities of `count` Gaussians come down to 0.01 where they are higher.
  static void LowerOpacities(float* x, Index count) {
    ForEach<Space>(count, kGrain, density::LowerLogit{x + splat::kOpacity * count});
  }

  // Whether what was read can be that of a model of so many Gaussians.
  bool IsOf(Index count) const { return most_ > 0 && pull_.size() == count && seen_.size() == count; }
  // What was observed, and for how many there turned out to be room; the rest are options, which may be others now.
  template <class Archive>
  void Visit(Archive& archive) {
    archive(most_, pull_, seen_);
  }

 private:
  static constexpr Index kGrain = 4096;

  DensityOptions options_;
  Index most_ = std::numeric_limits<Index>::max();
  double extent_;
  std::uint64_t seed_;
  Buffer<float, Space> pull_;
  Buffer<int, Space> seen_;
};

namespace density {

// Sums over the Gaussians of a number that goes with their fates.
template <class Space>
class FateSums {
 public:
  explicit FateSums(Index count) : count_(count), counts_(count + 1), begin_(count + 1) {}

  // The sum over all, and by Gaussian, in begin(), over those before it.
  Index Sum(const Buffer<DensifyAction, Space>& fate, const DensifyNumbers& numbers) {
    ForEach<Space>(count_ + 1, 4096, CountFate{count_, fate.data(), numbers, counts_.data()});
    return Sorting<Space>::RunningSum(counts_, begin_);
  }
  const Index* begin() const { return begin_.data(); }

 private:
  Index count_;
  Buffer<Index, Space> counts_, begin_;
};

// Candidates that find no room are kept as they are: the weakest, and of two alike the later.
template <class Space>
void LimitToBudget(const Observed& observed, Index candidates, Index room, DensifyAction* fate) {
  Buffer<std::uint32_t, Space> keys, indices;
  keys.ResizeForOverwrite(observed.count);
  indices.ResizeForOverwrite(observed.count);
  ForEach<Space>(observed.count, 4096, MakeStrengthKey{observed, fate, keys.data(), indices.data()});
  Sorting<Space>::ByKey(keys, indices);
  ForEach<Space>(candidates - room, 4096, KeepAsItIs{indices.data() + room, fate});
}

}  // namespace density

template <class Space>
DensityPlan<Space> DensityControl<Space>::Decide(const float* x, Index count) const {
  VESTA_CHECK(pull_.size() == count, "{} Gaussians were observed of {}", pull_.size(), count);
  VESTA_CHECK(count < Index{0xffffffff} / 2, "{} Gaussians", count);
  const density::Observed observed{count, x, pull_.data(), seen_.data()};
  DensityPlan<Space> plan;
  plan.fate.ResizeForOverwrite(count);
  density::FateSums<Space> sums(count);
  FateRule rule(options_, extent_);
  ForEach<Space>(count, kGrain, density::DecideFate{rule, observed, plan.fate.data()});
  Index kept = sums.Sum(plan.fate, kSurvivors);
  if (kept == 0) {
    // An empty model cannot be trained on: better keep what is there.
    rule.prunes = false;
    ForEach<Space>(count, kGrain, density::DecideFate{rule, observed, plan.fate.data()});
    kept = count;
  }
  // Each candidate, cloned or split, adds one.
  Index candidates = sums.Sum(plan.fate, kGrowing);
  const Index room = std::max<Index>(std::min(options_.max_gaussians, most_) - kept, 0);
  if (candidates > room) {
    density::LimitToBudget<Space>(observed, candidates, room, plan.fate.data());
    candidates = room;
  }
  plan.count = kept + candidates;
  plan.changes = kept < count || candidates > 0;
  if (!plan.changes) return plan;
  plan.source.ResizeForOverwrite(plan.count);
  plan.kept.ResizeForOverwrite(plan.count);
  sums.Sum(plan.fate, kChildren);
  ForEach<Space>(
      count, kGrain,
      density::PlaceChildren{kKeepingMoments, plan.fate.data(), sums.begin(), plan.source.data(), plan.kept.data()});
  return plan;
}

}  // namespace vesta::gs
