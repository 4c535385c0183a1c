// SPDX-License-Identifier: Apache-2.0
// Options of the Adam stage, and values that depend on its progress (StageSpan).
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "kernels/core/schema.h"
#include "problems/gaussian_splatting/scene/stage_span.h"

namespace vesta::gs {

enum class SecondMoment {
  kDiagonal,  // one second moment per parameter
  // Steps mean, log-scales, quaternion and opacity of a Gaussian in the eigenbasis of their gradients (adam_formula.h).
  // Stores 187 more numbers per Gaussian.
  kBlock,
};

struct AdamOptions {
  // Length of the stage in views; an iteration has batch_size views (NumIterations). Empty: the default for the scene
  // (FitToScene) times `iterations_scale`. 0: no Adam stage.
  std::optional<int> iterations = {};
  double iterations_scale = 1;
  // Views per iteration, whose gradients are summed.
  int batch_size = 1;
  SecondMoment second_moment = SecondMoment::kBlock;
  // Factor on all learning rates at the start. The learning rates of Kerbl et al. suit 30,000 iterations; shorter runs
  // need larger ones. The factor decays geometrically to lr_scale * lr_final_ratio.
  double lr_scale = 4.0;
  double lr_final_ratio = 0.5;
  // The stage returns a weighted mean of the parameters (parameter_mean.h) over this last fraction of the stage, or
  // since the last densification if that is later. The mean has less noise from high learning rates. 0: no mean.
  double averaging_fraction = 0.5;
  // Up to this fraction of the stage, images have half the width and height (coarse_views.h).
  double half_resolution_until = 0.5;
  // Interval, as a fraction of the stage, after which one more band of spherical harmonics becomes active; 0: all are
  // active from the start. The interval is doubled if exposures are optimised.
  double sh_degree_interval = 0.08;
  // Number of evaluations, evenly spaced; each adds a row to the history.
  int evaluations = 20;

  bool runs() const { return iterations != 0; }
};

const schema::Table<AdamOptions>& AdamFields();

// `iterations` (in views) divided by batch_size, rounded up.
inline int NumIterations(const AdamOptions& adam) {
  const int views = adam.batch_size, all = adam.iterations.value_or(0);
  return all / views + (all % views > 0 ? 1 : 0);
}

// Whether the training images have half width and height.
inline bool IsCoarse(const AdamOptions& adam, const StageSpan& span) {
  return span.IsWithin(adam.half_resolution_until);
}

// Factor on all learning rates.
inline double RateFactor(const AdamOptions& adam, const StageSpan& span) {
  return adam.lr_scale * std::pow(adam.lr_final_ratio, span.before);
}

// Whether the weighted mean includes the parameters after iteration `it`: about once in five views, since consecutive
// parameters are similar, and after the last iteration.
inline bool Averages(const AdamOptions& adam, const StageSpan& span, int it) {
  const int every = std::max(1, 5 / adam.batch_size);
  return !span.IsWithin(1 - adam.averaging_fraction) && (it % every == 0 || span.is_last());
}

// Active SH bands above band 0, at most sh_degree. band_every: see sh_degree_interval.
inline int ActiveShDegree(double band_every, int sh_degree, const StageSpan& span) {
  return band_every > 0 ? std::min(sh_degree, span.PartsBefore(band_every)) : sh_degree;
}

}  // namespace vesta::gs
