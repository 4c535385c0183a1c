#include "problems/gaussian_splatting/density/density.h"

#include <algorithm>

#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/gaussian_splatting/layout.h"
#include "problems/gaussian_splatting/density/screen_pull.h"
#include "problems/gaussian_splatting/model/gather_rows.h"

namespace vesta::gs {

DensityControl::DensityControl(const DensityOptions& options, double extent, std::uint64_t seed, Index count)
    : options_(options), extent_(extent), seed_(seed) {
  Forget(count);
}

void DensityControl::Forget(Index count) {
  pull_.assign(static_cast<std::size_t>(count), 0.0f);
  seen_.assign(static_cast<std::size_t>(count), 0);
}

void DensityControl::Observe(const splat::View<float>& view, const splat::SplatTangent<float>* splat_cotangents,
                             double loss_scale) {
  const auto half_width = static_cast<float>(0.5 * view.pinhole().width / loss_scale);
  const auto half_height = static_cast<float>(0.5 * view.pinhole().height / loss_scale);
  ParallelFor(static_cast<Index>(pull_.size()), 4096, [&](Index i) {
    const std::int32_t rank = view.rank_of()[i];
    if (rank < 0) return;
    pull_[static_cast<std::size_t>(i)] +=
        ScreenPull(view.splats()[rank], splat_cotangents[rank].w, half_width, half_height);
    ++seen_[static_cast<std::size_t>(i)];
  });
}

std::vector<Fate> DensityControl::Decide(const SplatModel& model) const {
  const Index count = model.count;
  const auto strength = [&](Index i) {
    return Strength(pull_[static_cast<std::size_t>(i)], seen_[static_cast<std::size_t>(i)]);
  };
  std::vector<Fate> fate(static_cast<std::size_t>(count));
  FateRule rule(options_, extent_);
  Index kept = 0;
  for (;; rule.prunes = false) {
    for (Index i = 0; i < count; ++i) {
      fate[static_cast<std::size_t>(i)] = rule(model.data.data(), count, i, strength(i));
      kept += kSurvivors(fate[static_cast<std::size_t>(i)]);
    }
    // An empty model cannot be trained on: better keep what is there.
    if (kept > 0 || count == 0) break;
  }

  HostBuffer<KeyValue> candidates, scratch;
  candidates.ResizeForOverwrite(std::count_if(fate.begin(), fate.end(), [](Fate f) { return kGrowing(f) > 0; }));
  // Each candidate, cloned or split, adds one.
  const Index room = std::max<Index>(options_.max_gaussians - kept, 0);
  if (candidates.size() <= room) return fate;
  Index next = 0;
  for (Index i = 0; i < count; ++i) {
    const Fate f = fate[static_cast<std::size_t>(i)];
    if (kGrowing(f) > 0) candidates[next++] = {StrengthKey(f, strength(i)), static_cast<std::uint32_t>(i)};
  }
  RadixSort(candidates, scratch);
  for (Index rank = room; rank < candidates.size(); ++rank) fate[candidates[rank].value] = Fate::kKeep;
  return fate;
}

void DensityControl::Densify(SplatModel& model, Adam& adam, int iteration) {
  const std::vector<Fate> fate = Decide(model);
  std::vector<Index> source;
  std::vector<bool> keep_moments;
  for (Index i = 0; i < model.count; ++i) {
    const Fate f = fate[static_cast<std::size_t>(i)];
    for (int heir = 0; heir < kHeirs(f); ++heir) {
      source.push_back(i);
      keep_moments.push_back(heir < kKeepingMoments(f));
    }
  }

  model.data = GatherRows(model.data, model.count, model.num_attributes(), source);
  model.count = static_cast<Index>(source.size());
  for (Index i = 0; i < model.count; ++i) {
    const Fate f = fate[static_cast<std::size_t>(source[static_cast<std::size_t>(i)])];
    Renew(model.data.data(), model.count, i, f, seed_, iteration);
  }
  adam.Rearrange(source, keep_moments, model.num_attributes());
  Forget(model.count);
}

void DensityControl::ResetOpacity(SplatModel& model, Adam& adam) {
  float* logit = model.attribute(splat::kOpacity);
  for (Index i = 0; i < model.count; ++i) logit[i] = LoweredLogit(logit[i]);
  adam.Reset(splat::kOpacity);
}

}  // namespace vesta::gs
