#include "kernels/core/launch.cuh"
#include "problems/gaussian_splatting/density/device_density_steps.h"
#include "problems/gaussian_splatting/density/screen_pull.h"

namespace vesta::gs::device_density {
namespace {

struct ObserveOne {
  Observation o;
  VESTA_HD void operator()(Index i) const {
    const std::int32_t rank = o.rank_of[i];
    if (rank < 0) return;
    o.pull[i] += ScreenPull(o.splats[rank], o.cotangents[rank].w, o.half_width, o.half_height);
    ++o.seen[i];
  }
};

struct DecideOne {
  FateRule rule;
  Observed o;
  Fate* fate;
  VESTA_HD void operator()(Index i) const { fate[i] = rule(o.x, o.count, i, Strength(o.pull[i], o.seen[i])); }
};

struct CountOne {
  Index count;
  const Fate* fate;
  FateNumbers numbers;
  Index* counts;
  VESTA_HD void operator()(Index i) const { counts[i] = i < count ? numbers(fate[i]) : 0; }
};

struct KeyOne {
  Observed o;
  const Fate* fate;
  std::uint32_t *keys, *indices;
  VESTA_HD void operator()(Index i) const {
    keys[i] = StrengthKey(fate[i], Strength(o.pull[i], o.seen[i]));
    indices[i] = static_cast<std::uint32_t>(i);
  }
};

struct KeepOne {
  const std::uint32_t* indices;
  Fate* fate;
  VESTA_HD void operator()(Index rank) const { fate[indices[rank]] = Fate::kKeep; }
};

struct PlaceOne {
  FateNumbers keeping;
  const Fate* fate;
  const Index* begin;
  std::uint32_t* source;
  std::uint8_t* kept;
  VESTA_HD void operator()(Index i) const {
    for (Index k = begin[i]; k < begin[i + 1]; ++k) {
      source[k] = static_cast<std::uint32_t>(i);
      kept[k] = k - begin[i] < keeping(fate[i]) ? 1 : 0;
    }
  }
};

struct RenewOne {
  Index count;
  const std::uint32_t* source;
  const Fate* fate;
  std::uint64_t seed;
  int iteration;
  float* x;
  VESTA_HD void operator()(Index i) const { Renew(x, count, i, fate[source[i]], seed, iteration); }
};

struct LowerOne {
  float* logits;
  VESTA_HD void operator()(Index i) const { logits[i] = LoweredLogit(logits[i]); }
};

}  // namespace

void Observe(Index count, const Observation& observation) {
  device::ForEach(count, ObserveOne{observation}, "density statistics");
}

void DecideFates(const FateRule& rule, const Observed& observed, Fate* fate) {
  device::ForEach(observed.count, DecideOne{rule, observed, fate}, "fates of Gaussians");
}

void CountFates(Index count, const Fate* fate, const FateNumbers& numbers, Index* counts) {
  device::ForEach(count + 1, CountOne{count, fate, numbers, counts}, "counts of fates");
}

void StrengthKeys(const Observed& observed, const Fate* fate, std::uint32_t* keys, std::uint32_t* indices) {
  device::ForEach(observed.count, KeyOne{observed, fate, keys, indices}, "keys of strength");
}

void KeepFrom(Index begin, Index end, const std::uint32_t* indices, Fate* fate) {
  device::ForEach(end - begin, KeepOne{indices + begin, fate}, "candidates without room");
}

void PlaceSources(Index count, const Fate* fate, const Index* begin, std::uint32_t* source, std::uint8_t* kept) {
  device::ForEach(count, PlaceOne{kKeepingMoments, fate, begin, source, kept}, "sources of Gaussians");
}

void RenewAll(Index count, const std::uint32_t* source, const Fate* fate, std::uint64_t seed, int iteration, float* x) {
  device::ForEach(count, RenewOne{count, source, fate, seed, iteration, x}, "clones and splits");
}

void LowerLogits(Index count, float* logits) { device::ForEach(count, LowerOne{logits}, "lowered opacities"); }

}  // namespace vesta::gs::device_density
