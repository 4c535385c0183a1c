#include "problems/gaussian_splatting/density/device_density.h"

#include "kernels/core/check.h"
#include "kernels/core/device_sort.h"
#include "problems/gaussian_splatting/density/device_density_steps.h"

namespace vesta::gs {
namespace {

// Sums over the Gaussians of a number that goes with their fates.
class FateSums {
 public:
  explicit FateSums(Index count) : count_(count), counts_(count + 1), begin_(count + 1) {}

  // The sum over all, and by Gaussian, in begin(), over those before it. Waits.
  Index Sum(const DeviceBuffer<Fate>& fate, const FateNumbers& numbers) {
    device_density::CountFates(count_, fate.data(), numbers, counts_.data());
    device::RunningSum(counts_.data(), begin_.data(), count_ + 1, temporary_);
    Index sum = 0;
    device::CopyToHost(&sum, begin_.data() + count_, sizeof(sum));
    return sum;
  }
  const Index* begin() const { return begin_.data(); }

 private:
  Index count_;
  DeviceBuffer<Index> counts_, begin_;
  DeviceBuffer<unsigned char> temporary_;
};

// Those that find no room are kept as they are: the weakest, and of two alike the later.
void KeepTheWeakest(const device_density::Observed& observed, Index candidates, Index room, Fate* fate) {
  DeviceBuffer<std::uint32_t> keys, indices, other_keys, other_indices;
  for (auto* buffer : {&keys, &indices, &other_keys, &other_indices}) buffer->ResizeForOverwrite(observed.count);
  DeviceBuffer<unsigned char> temporary;
  device_density::StrengthKeys(observed, fate, keys.data(), indices.data());
  constexpr int kKeyBits = 32;
  device::SortPairs(keys, indices, other_keys, other_indices, observed.count, kKeyBits, temporary);
  device_density::KeepFrom(room, candidates, indices.data(), fate);
}

}  // namespace

void DeviceDensityControl::Forget(Index count) {
  pull_.Resize(count);
  seen_.Resize(count);
}

void DeviceDensityControl::Observe(const splat::DeviceView& view, const splat::DeviceViewWorkspace& workspace,
                                   double loss_scale) {
  device_density::Observe(pull_.size(), {.rank_of = view.rank_of().data(),
                                         .splats = view.splats().data(),
                                         .cotangents = workspace.splat_sums.data(),
                                         .half_width = static_cast<float>(0.5 * view.pinhole().width / loss_scale),
                                         .half_height = static_cast<float>(0.5 * view.pinhole().height / loss_scale),
                                         .pull = pull_.data(),
                                         .seen = seen_.data()});
}

DensityPlan DeviceDensityControl::Decide(const float* x, Index count) const {
  VESTA_CHECK(pull_.size() == count, "{} Gaussians were observed of {}", pull_.size(), count);
  const device_density::Observed observed{count, x, pull_.data(), seen_.data()};
  DensityPlan plan;
  plan.fate.ResizeForOverwrite(count);
  FateSums sums(count);
  FateRule rule(options_, extent_);
  device_density::DecideFates(rule, observed, plan.fate.data());
  Index kept = sums.Sum(plan.fate, kSurvivors);
  if (kept == 0) {
    // An empty model cannot be trained on: better keep what is there.
    rule.prunes = false;
    device_density::DecideFates(rule, observed, plan.fate.data());
    kept = count;
  }
  // Each candidate, cloned or split, adds one.
  Index candidates = sums.Sum(plan.fate, kGrowing);
  const Index room = std::max<Index>(options_.max_gaussians - kept, 0);
  if (candidates > room) {
    KeepTheWeakest(observed, candidates, room, plan.fate.data());
    candidates = room;
  }
  plan.count = kept + candidates;
  plan.changes = kept < count || candidates > 0;
  if (!plan.changes) return plan;
  VESTA_CHECK(plan.count < Index{0xffffffff}, "{} Gaussians", plan.count);
  plan.source.ResizeForOverwrite(plan.count);
  plan.kept.ResizeForOverwrite(plan.count);
  sums.Sum(plan.fate, kHeirs);
  device_density::PlaceSources(count, plan.fate.data(), sums.begin(), plan.source.data(), plan.kept.data());
  return plan;
}

void DeviceDensityControl::Renew(const DensityPlan& plan, int iteration, float* x) const {
  device_density::RenewAll(plan.count, plan.source.data(), plan.fate.data(), seed_, iteration, x);
}

}  // namespace vesta::gs
