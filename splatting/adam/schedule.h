// When the Adam stage does what: rates, coarse views, bands of the spherical harmonics, the mean. The same on every
// device.
#pragma once

#include <algorithm>
#include <cmath>

#include "problems/gaussian_splatting/scene/stage_span.h"
#include "splatting/adam/options.h"

namespace vesta::gs {

// How many iterations the stage has: its length is given in views, and each iteration takes so many of them, the last
// one too.
inline int NumIterations(const AdamOptions& adam) {
  const int views = adam.views_per_iteration, all = adam.iterations.value_or(0);
  return all / views + (all % views > 0 ? 1 : 0);
}

// Whether it sees the views at half their size.
inline bool IsCoarse(const AdamOptions& adam, const StageSpan& span) { return span.IsWithin(adam.coarse_part); }

// What all rates are multiplied by.
inline double RateFactor(const AdamOptions& adam, const StageSpan& span) {
  return adam.rate_factor * std::pow(adam.rate_decay, span.before);
}

// Whether the parameters after iteration `it` count in their mean. Neighbours are alike: those after every fifth view
// do, and the last.
inline bool Averages(const AdamOptions& adam, const StageSpan& span, int it) {
  const int every = std::max(1, 5 / adam.views_per_iteration);
  return !span.IsWithin(1 - adam.average_part) && (it % every == 0 || span.is_last());
}

// band_every: a part of the stage; 0: all bands at once.
inline int ActiveShDegree(double band_every, int sh_degree, const StageSpan& span) {
  return band_every > 0 ? std::min(sh_degree, span.PartsBefore(band_every)) : sh_degree;
}

}  // namespace vesta::gs
