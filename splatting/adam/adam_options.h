// SPDX-License-Identifier: Apache-2.0
// Options of the Adam stage, and what they say at each part of it.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "kernels/core/schema.h"
#include "problems/gaussian_splatting/scene/stage_span.h"

namespace vesta::gs {

enum class SecondMoment {
  kDiagonal,  // each parameter has its own second moment
  // Mean, log-scales, quaternion and opacity of a Gaussian are stepped in the eigenbasis of their gradients
  // (adam_formula.h), for which 187 numbers more are kept of each Gaussian.
  kBlock,
};

struct AdamOptions {
  // The length of the stage in iterations of one view each (NumIterations). None: what the scene requires
  // (FitToScene), times `length`.
  std::optional<int> iterations = {};
  double iterations_scale = 1;
  // The gradient of an iteration is the sum over the next so many training views, in the order of the epochs.
  int batch_size = 1;
  // What scales the gradient of a Gaussian's geometry: of each parameter its own second moment, or of all eleven
  // together their eigenbasis (adam_formula.h).
  SecondMoment second_moment = SecondMoment::kBlock;
  // The authors' rates are made for 30,000 iterations; short runs want several times as much.
  // All rates times this at the start, and the factor by which they have fallen, geometrically, at the end.
  double lr_scale = 4.0;
  double lr_final_ratio = 0.5;
  // In the last part of the stage, this long, it shows and leaves the weighted mean of its parameters since the last
  // densification (parameter_mean.h), since high rates come far and end in noise; 0: the last ones.
  double averaging_fraction = 0.5;
  // The first part of the stage, this long, sees the views at half their size (coarse_views.h).
  double half_resolution_until = 0.5;
  // One more band of spherical harmonics after each of these parts of the run; twice as long where exposures are found
  // along (train/settings/training_plan.h).
  double sh_degree_interval = 0.08;
  // Rows of the history, evenly spaced.
  int evaluations = 20;

  // Whether there is an Adam stage.
  bool runs() const { return iterations != 0; }
};

const schema::Table<AdamOptions>& AdamFields();

// How many iterations the stage has: its length is given in views, and each iteration takes so many of them, the last
// one too.
inline int NumIterations(const AdamOptions& adam) {
  const int views = adam.batch_size, all = adam.iterations.value_or(0);
  return all / views + (all % views > 0 ? 1 : 0);
}

// Whether it sees the views at half their size.
inline bool IsCoarse(const AdamOptions& adam, const StageSpan& span) {
  return span.IsWithin(adam.half_resolution_until);
}

// What all rates are multiplied by.
inline double RateFactor(const AdamOptions& adam, const StageSpan& span) {
  return adam.lr_scale * std::pow(adam.lr_final_ratio, span.before);
}

// Whether the parameters after iteration `it` count in their mean. Neighbours are alike: those after every fifth view
// do, and the last.
inline bool Averages(const AdamOptions& adam, const StageSpan& span, int it) {
  const int every = std::max(1, 5 / adam.batch_size);
  return !span.IsWithin(1 - adam.averaging_fraction) && (it % every == 0 || span.is_last());
}

// band_every: a part of the stage; 0: all bands at once.
inline int ActiveShDegree(double band_every, int sh_degree, const StageSpan& span) {
  return band_every > 0 ? std::min(sh_degree, span.PartsBefore(band_every)) : sh_degree;
}

}  // namespace vesta::gs
