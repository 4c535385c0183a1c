// SPDX-License-Identifier: Apache-2.0
// The loops of density control, Gaussian by Gaussian. All pointers of one of these are to one memory space.
#pragma once

#include <cstdint>

#include "kernels/core/for_each.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "splatting/density/density_formula.h"

namespace vesta::gs::density {

// Parameters of `count` Gaussians, and what was observed of them.
struct Observed {
  Index count;
  const float* x;
  const float* pull;
  const int* seen;

  VESTA_HD float StrengthOf(Index i) const { return Strength(pull[i], seen[i]); }
};

// How strongly one view pulls at the Gaussians that it sees.
struct ScreenPulls {
  const std::int32_t* rank_of;
  const splat::Splat<float>* splats;
  const splat::SplatTangent<float>* cotangents;  // by rank
  float half_width, half_height;

  // Of a Gaussian that is seen.
  VESTA_HD float Of(Index i) const {
    const std::int32_t rank = rank_of[i];
    return ScreenPull(splats[rank], cotangents[rank].w, half_width, half_height);
  }
};

// splat_cotangents by rank (the workspace's splat_sums), of the loss times loss_scale.
template <class View>
ScreenPulls PullsOf(const View& view, const splat::SplatTangent<float>* splat_cotangents, double loss_scale) {
  return {.rank_of = view.rank_of().data(),
          .splats = view.splats().data(),
          .cotangents = splat_cotangents,
          .half_width = static_cast<float>(0.5 * view.camera().width / loss_scale),
          .half_height = static_cast<float>(0.5 * view.camera().height / loss_scale)};
}

// Where Gaussian i is seen: pull += ScreenPull, seen += 1.
struct Observe {
  ScreenPulls pulls;
  float* pull;
  int* seen;

  VESTA_HD void operator()(Index i) const {
    if (pulls.rank_of[i] < 0) return;
    pull[i] += pulls.Of(i);
    ++seen[i];
  }
};

struct DecideFate {
  FateRule rule;
  Observed observed;
  Fate* fate;
  VESTA_HD void operator()(Index i) const { fate[i] = rule(observed.x, observed.count, i, observed.StrengthOf(i)); }
};

// counts[i] = the number of fate[i], 0 for i = count.
struct CountFate {
  Index count;
  const Fate* fate;
  FateNumbers numbers;
  Index* counts;
  VESTA_HD void operator()(Index i) const { counts[i] = i < count ? numbers(fate[i]) : 0; }
};

// keys[i] = StrengthKey, indices[i] = i.
struct MakeStrengthKey {
  Observed observed;
  const Fate* fate;
  std::uint32_t *keys, *indices;
  VESTA_HD void operator()(Index i) const {
    keys[i] = StrengthKey(fate[i], observed.StrengthOf(i));
    indices[i] = static_cast<std::uint32_t>(i);
  }
};

// fate[indices[rank]] = kKeep.
struct KeepAsItIs {
  const std::uint32_t* indices;
  Fate* fate;
  VESTA_HD void operator()(Index rank) const { fate[indices[rank]] = Fate::kKeep; }
};

// For the heirs k in [begin[i], begin[i + 1]) of Gaussian i: source[k] = i, and whether k keeps the moments.
struct PlaceHeirs {
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

// Renew for Gaussian i of the `count` of the new model; fate by Gaussian of the old one.
struct RenewHeir {
  Index count;
  const std::uint32_t* source;
  const Fate* fate;
  std::uint64_t seed;
  int iteration;
  float* x;
  VESTA_HD void operator()(Index i) const { Renew(x, count, i, fate[source[i]], seed, iteration); }
};

struct LowerLogit {
  float* logits;
  VESTA_HD void operator()(Index i) const { logits[i] = LoweredLogit(logits[i]); }
};

}  // namespace vesta::gs::density
