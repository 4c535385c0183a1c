// SPDX-License-Identifier: Apache-2.0
// Options of the Adam stage, and their values at each point of the stage.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "kernels/core/schema.h"
#include "problems/gaussian_splatting/scene/stage_span.h"

namespace vesta::gs {

enum class SecondMoment {
  kDiagonal,  // one second moment per parameter
  // Mean, log-scales, quaternion and opacity of a Gaussian are stepped in the eigenbasis of their gradients
  // (adam_formula.h). This stores 187 more numbers per Gaussian.
  kBlock,
};

struct AdamOptions {
  // Length of the stage, in views processed (NumIterations). Empty: chosen from the scene (FitToScene), times
  // `iterations_scale`.
  std::optional<int> iterations = {};
  double iterations_scale = 1;
  // Views per iteration, in the order of the epochs. Their gradients are summed.
  int batch_size = 1;
  // Scaling of the gradient of a Gaussian's geometry: per parameter, or jointly for all eleven parameters in their
  // eigenbasis (adam_formula.h).
  SecondMoment second_moment = SecondMoment::kBlock;
  // lr_scale: factor on all learning rates at the start. The rates of Kerbl et al. are made for 30,000 iterations;
  // short runs need larger ones. lr_final_ratio: the factor by which they decay geometrically until the end.
  double lr_scale = 4.0;
  double lr_final_ratio = 0.5;
  // Last fraction of the stage that returns a weighted mean of the parameters since the last densification
  // (parameter_mean.h). High learning rates end in noise, which the mean removes. 0: the last parameters.
  double averaging_fraction = 0.5;
  // First fraction of the stage that uses images of half the width and height (coarse_views.h).
  double half_resolution_until = 0.5;
  // Fraction of the stage after which one more band of spherical harmonics becomes active. Twice as long if exposures
  // are optimised as well (train/settings/training_plan.h).
  double sh_degree_interval = 0.08;
  // Rows of the history, evenly spaced.
  int evaluations = 20;

  // Whether there is an Adam stage.
  bool runs() const { return iterations != 0; }
};

const schema::Table<AdamOptions>& AdamFields();

// Number of iterations. The length of the stage is given in views; each iteration takes batch_size of them, including
// the last one.
inline int NumIterations(const AdamOptions& adam) {
  const int views = adam.batch_size, all = adam.iterations.value_or(0);
  return all / views + (all % views > 0 ? 1 : 0);
}

// Whether the training images have half their width and height.
inline bool IsCoarse(const AdamOptions& adam, const StageSpan& span) {
  return span.IsWithin(adam.half_resolution_until);
}

// Factor on all learning rates.
inline double RateFactor(const AdamOptions& adam, const StageSpan& span) {
  return adam.lr_scale * std::pow(adam.lr_final_ratio, span.before);
}

// Whether the mean includes the parameters after iteration `it`: only those after every fifth view, since neighbours
// are similar, and the last ones.
inline bool Averages(const AdamOptions& adam, const StageSpan& span, int it) {
  const int every = std::max(1, 5 / adam.batch_size);
  return !span.IsWithin(1 - adam.averaging_fraction) && (it % every == 0 || span.is_last());
}

// band_every: a fraction of the stage; 0: all bands are active.
inline int ActiveShDegree(double band_every, int sh_degree, const StageSpan& span) {
  return band_every > 0 ? std::min(sh_degree, span.PartsBefore(band_every)) : sh_degree;
}

}  // namespace vesta::gs
