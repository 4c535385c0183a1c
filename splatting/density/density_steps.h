// SPDX-License-Identifier: Apache-2.0
// Adaptive density control per Gaussian, on host and device: its score, its action (keep, prune, clone or split), and
// the loops. x: parameters of `count` Gaussians; attribute a of Gaussian i is at a * count + i. Only mean, log-scale,
// quaternion and opacity logit are used (formulas/layout.h).
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "kernels/core/for_each.h"
#include "kernels/core/random.h"
#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/formulas/project.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/math/quaternion.h"
#include "splatting/density/density_options.h"

namespace vesta::gs {

inline namespace VESTA_ISA {

// Norm of the derivative of the loss by the projected mean (u, v), the score of adaptive density control (Kerbl et al.
// 2023, section 5.2). u and v are in normalised device coordinates: 1 is half_width or half_height pixels. w:
// derivatives of the loss by the parameters of the projected splat (SplatTangent).
VESTA_HD inline float Grad2d(const splat::Splat<float>& splat, const float* w, float half_width, float half_height) {
  using std::hypot;
  float by_u, by_v;
  splat::ScreenMeanAdjoint(splat.r, splat.s, splat.beta, w, by_u, by_v);
  return hypot(by_u * half_width, by_v * half_height);
}

}  // namespace VESTA_ISA

enum class DensifyAction : std::uint8_t { kKeep, kPrune, kClone, kSplit };

inline namespace VESTA_ISA {

// A number for each action. Device kernels receive the constants below as arguments, since device code cannot read host
// variables.
struct DensifyNumbers {
  int keep, prune, clone, split;
  VESTA_HD constexpr int operator()(DensifyAction action) const {
    if (action == DensifyAction::kKeep) return keep;
    if (action == DensifyAction::kPrune) return prune;
    return action == DensifyAction::kClone ? clone : split;
  }
};
// kSurvivors: 1 unless the Gaussian is pruned. kGrowing: 1 if it becomes two.
inline constexpr DensifyNumbers kSurvivors{1, 0, 1, 1}, kGrowing{0, 0, 1, 1};
// kChildren: number of Gaussians that replace one. They take its place, so neighbours in memory stay neighbours in
// space. kKeepingMoments: how many of them keep Adam's moments; after a split, none.
inline constexpr DensifyNumbers kChildren{1, 0, 2, 2}, kKeepingMoments{1, 0, 1, 0};

inline constexpr float kSplitShrink = 1.6f;         // factor by which the children of a split are smaller
inline constexpr float kResetLogit = -4.59511985f;  // opacity 0.01

// Largest standard deviation, world units.
VESTA_HD inline float LargestScale(const float* x, Index count, Index i) {
  using std::exp;
  float largest = x[splat::kLogScale * count + i];
  for (int k = 1; k < 3; ++k) {
    const float next = x[(splat::kLogScale + k) * count + i];
    if (largest < next) largest = next;
  }
  return exp(largest);
}

VESTA_HD inline float Opacity(const float* x, Index count, Index i) {
  using std::exp;
  return 1 / (1 + exp(-x[splat::kOpacity * count + i]));
}

// The action for a Gaussian, without the limit on their number (LimitToBudget).
struct ActionRule {
  double prune_opa, grow_grad2d;
  float prune_scale3d, grow_scale3d;  // world units; prune_scale3d 0: no limit
  bool prunes = true;

  ActionRule(const DensityOptions& options, double extent)
      : prune_opa(options.prune_opa),
        grow_grad2d(options.grow_grad2d),
        prune_scale3d(static_cast<float>(options.prune_scale3d * extent)),
        grow_scale3d(static_cast<float>(options.grow_scale3d * extent)) {}

  // strength: from MeanGrad2d().
  VESTA_HD DensifyAction operator()(const float* x, Index count, Index i, float strength) const {
    if (prunes) {
      const bool huge = prune_scale3d > 0 && LargestScale(x, count, i) > prune_scale3d;
      if (huge || Opacity(x, count, i) < prune_opa) return DensifyAction::kPrune;
    }
    if (!(strength > grow_grad2d)) return DensifyAction::kKeep;
    return LargestScale(x, count, i) > grow_scale3d ? DensifyAction::kSplit : DensifyAction::kClone;
  }
};

// Mean gradient over the views that saw a Gaussian. grad2d: sum of Grad2d; seen: number of views. Without views
// -infinity, which is below every threshold.
VESTA_HD inline float MeanGrad2d(float grad2d, int seen) {
  return seen == 0 ? -std::numeric_limits<float>::infinity() : grad2d / static_cast<float>(seen);
}

// Ascending keys sort Gaussians by decreasing strength. Gaussians that do not grow come last.
VESTA_HD inline std::uint32_t StrengthKey(DensifyAction action, float strength) {
  if (action != DensifyAction::kClone && action != DensifyAction::kSplit) return ~std::uint32_t{0};
  // The bits of non-negative floats sort as the floats do.
  return std::uint32_t{0x7fffffff} - std::bit_cast<std::uint32_t>(strength);
}

// Opacity logit of two equal Gaussians that are together as opaque as one with the given logit (Rota Bulo et al. 2024,
// section 3.2).
VESTA_HD inline float LogitOfEachOfTwo(float logit) {
  using std::exp, std::log, std::sqrt;
  // In double: exp of a large logit overflows in float.
  const double root = sqrt(1 + exp(double{logit}));  // 1 / sqrt(1 - opacity)
  return static_cast<float>(log(root - 1));
}

// Moves the mean of Gaussian i to a random sample of its distribution, and divides its scales by kSplitShrink.
VESTA_HD inline void MoveToSample(float* x, Index count, Index i, CounterRandom random) {
  using std::exp, std::log;
  float q[4], R[9];
  for (int k = 0; k < 4; ++k) q[k] = x[(splat::kQuaternion + k) * count + i];
  RotationFromQuaternion(q, R);
  float offset[3];
  for (int k = 0; k < 3; ++k) {
    float& log_scale = x[(splat::kLogScale + k) * count + i];
    offset[k] = exp(log_scale) * static_cast<float>(random.Normal());
    log_scale -= log(kSplitShrink);
  }
  for (int r = 0; r < 3; ++r) {
    x[(splat::kMean + r) * count + i] += R[3 * r] * offset[0] + R[3 * r + 1] * offset[1] + R[3 * r + 2] * offset[2];
  }
}

// Before the call, Gaussian i of the new model is a copy of its source.
VESTA_HD inline void ApplyAction(float* x, Index count, Index i, DensifyAction action, std::uint64_t seed,
                                 int iteration) {
  if (action == DensifyAction::kClone) {
    float& logit = x[splat::kOpacity * count + i];
    logit = LogitOfEachOfTwo(logit);
  } else if (action == DensifyAction::kSplit) {
    MoveToSample(x, count, i,
                 CounterRandom(seed, static_cast<std::uint64_t>(iteration), static_cast<std::uint64_t>(i)));
  }
}

VESTA_HD inline float LoweredLogit(float logit) { return kResetLogit < logit ? kResetLogit : logit; }

}  // namespace VESTA_ISA
}  // namespace vesta::gs

namespace vesta::gs::density {

// Parameters and statistics of `count` Gaussians.
struct Observed {
  Index count;
  const float* x;
  const float* grad2d;
  const int* seen;

  VESTA_HD float StrengthOf(Index i) const { return MeanGrad2d(grad2d[i], seen[i]); }
};

// Image-space gradients in one view.
struct Grad2dView {
  const std::int32_t* rank_of;                   // depth rank by Gaussian; -1: not visible
  const splat::Splat<float>* splats;             // by rank
  const splat::SplatTangent<float>* cotangents;  // by rank
  float half_width, half_height;

  // i must be visible in the view.
  VESTA_HD float Of(Index i) const {
    const std::int32_t rank = rank_of[i];
    return Grad2d(splats[rank], cotangents[rank].w, half_width, half_height);
  }
};

// splat_cotangents: derivatives of loss_scale times the loss, by rank (the workspace's splat_sums).
template <class View>
Grad2dView Grad2dOf(const View& view, const splat::SplatTangent<float>* splat_cotangents, double loss_scale) {
  return {.rank_of = view.rank_of().data(),
          .splats = view.splats().data(),
          .cotangents = splat_cotangents,
          .half_width = static_cast<float>(0.5 * view.camera().width / loss_scale),
          .half_height = static_cast<float>(0.5 * view.camera().height / loss_scale)};
}

// If Gaussian i is visible: grad2d += Grad2d, seen += 1.
struct Observe {
  Grad2dView grad2d_view;
  float* grad2d;
  int* seen;

  VESTA_HD void operator()(Index i) const {
    if (grad2d_view.rank_of[i] < 0) return;
    grad2d[i] += grad2d_view.Of(i);
    ++seen[i];
  }
};

struct DecideAction {
  ActionRule rule;
  Observed observed;
  DensifyAction* action;
  VESTA_HD void operator()(Index i) const { action[i] = rule(observed.x, observed.count, i, observed.StrengthOf(i)); }
};

// counts[i] = numbers(action[i]); 0 for i = count.
struct CountActions {
  Index count;
  const DensifyAction* action;
  DensifyNumbers numbers;
  Index* counts;
  VESTA_HD void operator()(Index i) const { counts[i] = i < count ? numbers(action[i]) : 0; }
};

// keys[i] = StrengthKey, indices[i] = i.
struct MakeStrengthKey {
  Observed observed;
  const DensifyAction* action;
  std::uint32_t *keys, *indices;
  VESTA_HD void operator()(Index i) const {
    keys[i] = StrengthKey(action[i], observed.StrengthOf(i));
    indices[i] = static_cast<std::uint32_t>(i);
  }
};

// action[indices[rank]] = kKeep.
struct KeepAsItIs {
  const std::uint32_t* indices;
  DensifyAction* action;
  VESTA_HD void operator()(Index rank) const { action[indices[rank]] = DensifyAction::kKeep; }
};

// For the children k in [begin[i], begin[i + 1]) of Gaussian i: source[k] = i, and kept[k] = 1 for the first
// keeping(action[i]) of them, else 0.
struct PlaceChildren {
  DensifyNumbers keeping;
  const DensifyAction* action;
  const Index* begin;
  std::uint32_t* source;
  std::uint8_t* kept;
  VESTA_HD void operator()(Index i) const {
    for (Index k = begin[i]; k < begin[i + 1]; ++k) {
      source[k] = static_cast<std::uint32_t>(i);
      kept[k] = k - begin[i] < keeping(action[i]) ? 1 : 0;
    }
  }
};

// ApplyAction for Gaussian i of the new model with `count` Gaussians; action: by Gaussian of the old model.
struct InitChild {
  Index count;
  const std::uint32_t* source;
  const DensifyAction* action;
  std::uint64_t seed;
  int iteration;
  float* x;
  VESTA_HD void operator()(Index i) const { ApplyAction(x, count, i, action[source[i]], seed, iteration); }
};

struct LowerLogit {
  float* logits;
  VESTA_HD void operator()(Index i) const { logits[i] = LoweredLogit(logits[i]); }
};

}  // namespace vesta::gs::density
