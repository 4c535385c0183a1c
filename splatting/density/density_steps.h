// SPDX-License-Identifier: Apache-2.0
// Density control per Gaussian, on host and device: its score, its action (keep, prune or split), and the loops. x:
// parameters of `count` Gaussians; attribute a of Gaussian i is at a * count + i. Only mean, log-scale, quaternion and
// opacity logit are used (formulas/layout.h).
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "kernels/core/for_each.h"
#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/math/quaternion.h"
#include "splatting/density/density_options.h"

namespace vesta::gs {

enum class DensifyAction : std::uint8_t { kKeep, kPrune, kSplit };

inline namespace VESTA_ISA {

// A number for each action. Device kernels receive the constants below as arguments, since device code cannot read host
// variables.
struct DensifyNumbers {
  int keep, prune, split;
  VESTA_HD constexpr int operator()(DensifyAction action) const {
    if (action == DensifyAction::kKeep) return keep;
    return action == DensifyAction::kPrune ? prune : split;
  }
};
// kSurvivors: 1 unless the Gaussian is pruned. kGrowing: 1 if it becomes two.
inline constexpr DensifyNumbers kSurvivors{1, 0, 1}, kGrowing{0, 0, 1};
// kChildren: number of Gaussians that replace one. They take its place, so neighbours in memory stay neighbours in
// space.
inline constexpr DensifyNumbers kChildren{1, 0, 2};

inline constexpr float kResetLogit = -4.59511985f;  // opacity 0.01

// Index of the longest axis, 0 to 2.
VESTA_HD inline int LongestAxis(const float* x, Index count, Index i) {
  int longest = 0;
  for (int k = 1; k < 3; ++k) {
    if (x[(splat::kLogScale + longest) * count + i] < x[(splat::kLogScale + k) * count + i]) longest = k;
  }
  return longest;
}

// Largest standard deviation, world units.
VESTA_HD inline float LargestScale(const float* x, Index count, Index i) {
  using std::exp;
  return exp(x[(splat::kLogScale + LongestAxis(x, count, i)) * count + i]);
}

VESTA_HD inline float Opacity(const float* x, Index count, Index i) {
  using std::exp;
  return 1 / (1 + exp(-x[splat::kOpacity * count + i]));
}

// The action for a Gaussian, without the limit on their number (LimitToBudget).
struct ActionRule {
  float threshold;      // a Gaussian with a larger pull is split
  float prune_scale3d;  // world units; 0: no limit
  double prune_opa;
  bool prunes = true;

  VESTA_HD DensifyAction operator()(const float* x, Index count, Index i, float pull) const {
    if (prunes) {
      const bool huge = prune_scale3d > 0 && LargestScale(x, count, i) > prune_scale3d;
      if (huge || Opacity(x, count, i) < prune_opa) return DensifyAction::kPrune;
    }
    return pull > threshold ? DensifyAction::kSplit : DensifyAction::kKeep;
  }
};

// Ascending keys sort Gaussians by decreasing pull. Gaussians that do not grow come last.
VESTA_HD inline std::uint32_t PullKey(DensifyAction action, float pull) {
  if (action != DensifyAction::kSplit) return ~std::uint32_t{0};
  // The bits of non-negative floats sort as the floats do.
  return std::uint32_t{0x7fffffff} - std::bit_cast<std::uint32_t>(pull);
}

// Opacity logit of each half (SplitInTwo). The optical depth -log(1 - opacity) is divided by sqrt(2).
VESTA_HD inline float LogitOfHalf(float logit) {
  using std::exp, std::expm1, std::log, std::log1p, std::sqrt;
  constexpr float kOpaque = 30;  // log(1 + exp(logit)) is the logit; exp of larger ones may overflow
  const double whole = logit > kOpaque ? double{logit} : log1p(exp(double{logit})), depth = whole / sqrt(2.0);
  return static_cast<float>(depth + log(-expm1(-depth)));  // log(exp(depth) - 1)
}

// Turns Gaussian i into one half of itself. The halves lie at -1 and +1 (sign) times 1 / sqrt(2) of the standard
// deviation along the longest axis, where their own standard deviation is 1 / sqrt(2) of the old one. Together they
// keep the mean, the covariance and, where opacities are small, the integral of opacity.
VESTA_HD inline void SplitInTwo(float* x, Index count, Index i, float sign) {
  using std::exp;
  const float half_scale = 0.70710678f, log_half_scale = -0.34657359f;
  const int axis = LongestAxis(x, count, i);
  float q[4], R[9];
  for (int k = 0; k < 4; ++k) q[k] = x[(splat::kQuaternion + k) * count + i];
  RotationFromQuaternion(q, R);
  float& log_scale = x[(splat::kLogScale + axis) * count + i];
  const float offset = sign * half_scale * exp(log_scale);
  for (int r = 0; r < 3; ++r) x[(splat::kMean + r) * count + i] += offset * R[3 * r + axis];
  log_scale += log_half_scale;
  float& logit = x[splat::kOpacity * count + i];
  logit = LogitOfHalf(logit);
}

VESTA_HD inline float LoweredLogit(float logit) { return kResetLogit < logit ? kResetLogit : logit; }

}  // namespace VESTA_ISA
}  // namespace vesta::gs

namespace vesta::gs::density {

// The pulls in one view. The pull of a Gaussian is the sum over its pixels of the absolute change of the loss if only
// the pixel's part of the Gaussian moved by one pixel of the full-size image. Pixels that pull in different directions
// add up, as in AbsGS (Ye et al. 2024). The two whitened directions count as independent
// (docs/mathematics.md, "Pull").
struct PullView {
  const std::int32_t* rank_of;                   // depth rank by Gaussian; -1: not visible
  const splat::Splat<float>* splats;             // by rank
  const splat::SplatTangent<float>* cotangents;  // by rank, of the loss summed over pixels and channels
  float scale;                                   // full-size pixels per side of a pixel

  // i must be visible in the view.
  VESTA_HD float Of(Index i) const {
    using std::sqrt;
    const splat::Splat<float>& splat = splats[rank_of[i]];
    const float* w = cotangents[rank_of[i]].w;
    const float p = splat.r * w[splat::kPullP], q = splat.s * w[splat::kPullQ];
    return scale * static_cast<float>(splat::kTwoLn2) * sqrt((1 + splat.beta * splat.beta) * p * p + q * q);
  }
};

// pull += PullView::Of, if Gaussian i is visible.
struct Observe {
  PullView view;
  float* pull;

  VESTA_HD void operator()(Index i) const {
    if (view.rank_of[i] >= 0) pull[i] += view.Of(i);
  }
};

struct DecideAction {
  ActionRule rule;
  Index count;
  const float *x, *pull;
  DensifyAction* action;
  VESTA_HD void operator()(Index i) const { action[i] = rule(x, count, i, pull[i]); }
};

// counts[i] = numbers(action[i]); 0 for i = count.
struct CountActions {
  Index count;
  const DensifyAction* action;
  DensifyNumbers numbers;
  Index* counts;
  VESTA_HD void operator()(Index i) const { counts[i] = i < count ? numbers(action[i]) : 0; }
};

// keys[i] = PullKey, indices[i] = i.
struct MakePullKey {
  const float* pull;
  const DensifyAction* action;
  std::uint32_t *keys, *indices;
  VESTA_HD void operator()(Index i) const {
    keys[i] = PullKey(action[i], pull[i]);
    indices[i] = static_cast<std::uint32_t>(i);
  }
};

// action[indices[rank]] = kKeep.
struct KeepAsItIs {
  const std::uint32_t* indices;
  DensifyAction* action;
  VESTA_HD void operator()(Index rank) const { action[indices[rank]] = DensifyAction::kKeep; }
};

// For the children k in [begin[i], begin[i + 1]) of Gaussian i: source[k] = i. kept[k]: 1 if the child keeps Adam's
// moments; halves do not.
struct PlaceChildren {
  const DensifyAction* action;
  const Index* begin;
  std::uint32_t* source;
  std::uint8_t* kept;
  VESTA_HD void operator()(Index i) const {
    for (Index k = begin[i]; k < begin[i + 1]; ++k) {
      source[k] = static_cast<std::uint32_t>(i);
      kept[k] = action[i] == DensifyAction::kKeep ? 1 : 0;
    }
  }
};

// SplitInTwo for Gaussian i of the new model with `count` Gaussians, if its source is split. The halves are neighbours.
// action: by Gaussian of the old model.
struct InitChild {
  Index count;
  const std::uint32_t* source;
  const DensifyAction* action;
  float* x;
  VESTA_HD void operator()(Index i) const {
    if (action[source[i]] != DensifyAction::kSplit) return;
    const bool is_first = i + 1 < count && source[i + 1] == source[i];
    SplitInTwo(x, count, i, is_first ? 1.0f : -1.0f);
  }
};

struct LowerLogit {
  float* logits;
  VESTA_HD void operator()(Index i) const { logits[i] = LoweredLogit(logits[i]); }
};

}  // namespace vesta::gs::density
