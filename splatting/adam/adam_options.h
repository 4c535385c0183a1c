// SPDX-License-Identifier: Apache-2.0
// Options of the Adam stage, and functions for the values that depend on the progress of the stage (StageSpan).
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
  // Length of the stage in processed views, which are batch_size per iteration (NumIterations). Empty: the default for
  // the scene (FitToScene) times `iterations_scale`. 0: no Adam stage.
  std::optional<int> iterations = {};
  double iterations_scale = 1;
  // Views per iteration. Their gradients are summed.
  int batch_size = 1;
  // Second moments of the eleven geometric parameters of a Gaussian.
  SecondMoment second_moment = SecondMoment::kBlock;
  // lr_scale: factor on all learning rates at the start. The learning rates of Kerbl et al. suit 30,000 iterations;
  // shorter runs need larger ones. The factor decays geometrically to lr_scale * lr_final_ratio at the end.
  double lr_scale = 4.0;
  double lr_final_ratio = 0.5;
  // The stage returns a weighted mean of the parameters over this last fraction of it, or since the last densification
  // if that is later (parameter_mean.h). High learning rates leave noise in the parameters, which the mean removes. 0:
  // the stage returns the last parameters.
  double averaging_fraction = 0.5;
  // First fraction of the stage that uses images of half the width and height (coarse_views.h).
  double half_resolution_until = 0.5;
  // Each time this fraction of the stage has passed, one more band of spherical harmonics becomes active; 0: all are
  // active from the start. The interval is twice as long if exposures are optimised.
  double sh_degree_interval = 0.08;
  // Number of evaluations, evenly spaced; each adds a row to the history.
  int evaluations = 20;

  // Whether there is an Adam stage.
  bool runs() const { return iterations != 0; }
};

const schema::Table<AdamOptions>& AdamFields();

// Number of iterations: `iterations` (in views) divided by batch_size, rounded up.
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

// Whether the weighted mean includes the parameters after iteration `it`. It includes them about once in five views,
// since consecutive parameters are similar, and after the last iteration.
inline bool Averages(const AdamOptions& adam, const StageSpan& span, int it) {
  const int every = std::max(1, 5 / adam.batch_size);
  return !span.IsWithin(1 - adam.averaging_fraction) && (it % every == 0 || span.is_last());
}

// Number of active SH bands above band 0, at most sh_degree. band_every: see sh_degree_interval.
inline int ActiveShDegree(double band_every, int sh_degree, const StageSpan& span) {
  return band_every > 0 ? std::min(sh_degree, span.PartsBefore(band_every)) : sh_degree;
}

}  // namespace vesta::gs
